package dev.ml2sensors.transport

import java.net.Socket
import java.security.Principal
import java.security.PrivateKey
import java.security.cert.X509Certificate
import javax.net.ssl.SSLEngine
import javax.net.ssl.X509ExtendedKeyManager

/** Presents [identity] to every server that asks: only a pinned receiver gets that far. */
internal class IdentityKeys(private val identity: DeviceIdentity) : X509ExtendedKeyManager() {
    override fun getCertificateChain(alias: String?): Array<X509Certificate> = arrayOf(identity.certificate)

    override fun getPrivateKey(alias: String?): PrivateKey = identity.privateKey

    override fun getClientAliases(keyType: String?, issuers: Array<Principal>?): Array<String> = arrayOf(ALIAS)

    override fun chooseClientAlias(keyTypes: Array<String>?, issuers: Array<Principal>?, socket: Socket?) = ALIAS

    override fun chooseEngineClientAlias(keyTypes: Array<String>?, issuers: Array<Principal>?, engine: SSLEngine?) =
        ALIAS

    override fun getServerAliases(keyType: String?, issuers: Array<Principal>?): Array<String>? = null

    override fun chooseServerAlias(keyType: String?, issuers: Array<Principal>?, socket: Socket?): String? = null

    private companion object {
        const val ALIAS = "device"
    }
}
