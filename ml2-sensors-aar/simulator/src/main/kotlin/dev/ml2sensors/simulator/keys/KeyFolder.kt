package dev.ml2sensors.simulator.keys

import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.transport.DeviceIdentity
import java.io.IOException
import java.nio.file.FileSystemException
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
import kotlin.io.path.isDirectory
import kotlin.io.path.outputStream
import kotlin.io.path.readBytes

/** The keys of a simulated headset: a [folder] with `device.p12`, created if it is missing, and `receivers.json`. */
internal class KeyFolder(private val folder: Path) {
    private val keyFile = folder.resolve("device.p12")

    /**
     * @param name the name of the device in a key that is created.
     * @throws IOException if the folder cannot be used.
     */
    fun open(name: String): DeviceKeys {
        if (folder.exists() && !folder.isDirectory()) {
            throw IOException("expected a folder of keys, found the file $folder: give its folder, or a new one")
        }
        if (!keyFile.exists()) {
            try {
                create(name)
            } catch (e: IOException) {
                throw IOException("cannot write in $folder: give a folder that this user can write (${reason(e)})", e)
            }
        }
        return DeviceKeys(load(), folder.resolve("receivers.json").toFile())
    }

    private fun load(): DeviceIdentity {
        val content = try {
            keyFile.readBytes()
        } catch (e: IOException) {
            throw IOException("cannot read $keyFile: expected a file that this user can read (${reason(e)})", e)
        }
        return try {
            identity(content)
        } catch (e: IOException) {
            throw notAKeyFile(e)
        } catch (e: GeneralSecurityException) {
            throw notAKeyFile(e)
        } ?: throw notAKeyFile(null)
    }

    /** @return null if the key store holds no device key. */
    private fun identity(content: ByteArray): DeviceIdentity? {
        val store = KeyStore.getInstance(FORMAT).apply { load(content.inputStream(), PASSWORD) }
        val key = store.getKey(ALIAS, PASSWORD) as? PrivateKey ?: return null
        return (store.getCertificate(ALIAS) as? X509Certificate)?.let { DeviceIdentity(key, it) }
    }

    /** The cause holds the message of the format's parser, which does not help users. */
    private fun notAKeyFile(cause: Exception?) = IOException(
        "expected the key that ml2-headset has written in $keyFile, found something else: remove the file, and pair again",
        cause,
    )

    private fun reason(failure: IOException) =
        (failure as? FileSystemException)?.reason ?: failure.javaClass.simpleName.removeSuffix("Exception")

    private fun create(name: String) {
        folder.createDirectories(PosixFilePermissions.asFileAttribute(PosixFilePermissions.fromString("rwx------")))
        val keys = KeyPairGenerator.getInstance("EC").run {
            initialize(ECGenParameterSpec("secp256r1"))
            generateKeyPair()
        }
        val store = KeyStore.getInstance(FORMAT).apply {
            load(null, null)
            setKeyEntry(ALIAS, keys.private, PASSWORD, arrayOf(selfSignedCertificate(keys, name)))
        }
        val written = Files.createTempFile(folder, "device", null) // The mode is 0600
        written.outputStream().use { store.store(it, PASSWORD) }
        Files.move(written, keyFile, StandardCopyOption.ATOMIC_MOVE)
    }

    companion object {
        private const val FORMAT = "PKCS12"
        private const val ALIAS = "device"

        /** The format requires a password; the mode of the file protects the key. */
        private val PASSWORD = "ml2-sensors".toCharArray()

        /** Returns the default folder of the keys. */
        fun default(): Path {
            val configuration = System.getenv("XDG_CONFIG_HOME")?.takeIf(String::isNotEmpty)?.let(::Path)
                ?: Path(System.getProperty("user.home"), ".config")
            return configuration.resolve("ml2-sensors-headset")
        }
    }
}
