package dev.ml2sensors.simulator.keys

import dev.ml2sensors.link.DeviceIdentity
import dev.ml2sensors.pairing.DeviceKeys
import java.io.IOException
import java.nio.file.Files
import java.nio.file.Path
import java.nio.file.StandardCopyOption
import java.nio.file.attribute.PosixFilePermissions
import java.security.GeneralSecurityException
import java.security.KeyPairGenerator
import java.security.KeyStore
import java.security.PrivateKey
import java.security.cert.X509Certificate
import java.security.spec.ECGenParameterSpec
import kotlin.io.path.Path
import kotlin.io.path.createDirectories
import kotlin.io.path.exists
import kotlin.io.path.inputStream
import kotlin.io.path.outputStream

/** The keys of a headset that is a program: the [folder] with `device.p12`, made when missing, and `receivers.json`. */
internal class KeyFolder(private val folder: Path) {
    private val keyFile = folder.resolve("device.p12")

    /**
     * @param name of the device, if its key is yet to be made.
     * @throws IOException when the folder cannot be used.
     */
    fun open(name: String): DeviceKeys {
        if (!keyFile.exists()) make(name)
        val identity = try {
            load()
        } catch (e: GeneralSecurityException) {
            throw IOException("$keyFile is damaged: ${e.message}", e)
        }
        return DeviceKeys(identity, folder.resolve("receivers.json").toFile())
    }

    private fun load(): DeviceIdentity {
        val store = KeyStore.getInstance(FORMAT)
        try {
            keyFile.inputStream().use { store.load(it, PASSWORD) }
        } catch (e: IOException) {
            throw IOException("cannot read $keyFile: ${e.message}", e)
        }
        val key = store.getKey(ALIAS, PASSWORD) as? PrivateKey
        val certificate = store.getCertificate(ALIAS) as? X509Certificate
        if (key == null || certificate == null) throw IOException("$keyFile has no key '$ALIAS' with its certificate")
        return DeviceIdentity(key, certificate)
    }

    private fun make(name: String) {
        folder.createDirectories(PosixFilePermissions.asFileAttribute(PosixFilePermissions.fromString("rwx------")))
        val keys = KeyPairGenerator.getInstance("EC").run {
            initialize(ECGenParameterSpec("secp256r1"))
            generateKeyPair()
        }
        val store = KeyStore.getInstance(FORMAT).apply {
            load(null, null)
            setKeyEntry(ALIAS, keys.private, PASSWORD, arrayOf(selfSignedCertificate(keys, name)))
        }
        val written = Files.createTempFile(folder, "device", null) // Of mode 0600
        written.outputStream().use { store.store(it, PASSWORD) }
        Files.move(written, keyFile, StandardCopyOption.ATOMIC_MOVE)
    }

    companion object {
        private const val FORMAT = "PKCS12"
        private const val ALIAS = "device"

        /** The format wants one; what protects the key is the mode of the file. */
        private val PASSWORD = "ml2-sensors".toCharArray()

        /** Where the keys are unless said otherwise. */
        fun default(): Path {
            val configuration = System.getenv("XDG_CONFIG_HOME")?.takeIf(String::isNotEmpty)?.let(::Path)
                ?: Path(System.getProperty("user.home"), ".config")
            return configuration.resolve("ml2-sensors-headset")
        }
    }
}
