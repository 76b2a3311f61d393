package dev.ml2sensors.simulator.keys

import org.junit.jupiter.api.io.TempDir
import java.io.IOException
import java.nio.file.Path
import java.nio.file.attribute.PosixFilePermissions
import java.security.interfaces.ECPublicKey
import java.time.Instant
import kotlin.io.path.getPosixFilePermissions
import kotlin.io.path.listDirectoryEntries
import kotlin.io.path.name
import kotlin.io.path.writeText
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue

class KeyFolderTest {
    @TempDir
    lateinit var parent: Path

    private val folder get() = parent.resolve("a/b")

    @Test
    fun theCertificateHasTheFieldsThatTheProtocolRequires() {
        val certificate = KeyFolder(folder).open("Größe").identity.certificate
        certificate.verify(certificate.publicKey)
        assertEquals("CN=Größe", certificate.subjectX500Principal.name)
        assertEquals(certificate.subjectX500Principal, certificate.issuerX500Principal)
        assertEquals("SHA256withECDSA", certificate.sigAlgName)
        assertEquals(3, certificate.version)
        assertEquals(Instant.parse("2000-01-01T00:00:00Z"), certificate.notBefore.toInstant())
        assertEquals(Instant.parse("9999-12-31T23:59:59Z"), certificate.notAfter.toInstant())
        val key = certificate.publicKey as ECPublicKey
        assertEquals(256, key.params.order.bitLength())
        assertTrue(certificate.serialNumber.signum() > 0)
    }

    @Test
    fun namesOfAnyLengthGiveValidCertificates() {
        for (length in listOf(1, 127, 128, 200, 300)) {
            val name = "n".repeat(length)
            val certificate = KeyFolder(parent.resolve("$length")).open(name).identity.certificate
            certificate.verify(certificate.publicKey)
            assertEquals("CN=$name", certificate.subjectX500Principal.name)
        }
    }

    @Test
    fun keysAreCreatedOnceAndReadableByTheOwnerOnly() {
        val first = KeyFolder(folder).open("first").identity.fingerprint
        assertEquals(first, KeyFolder(folder).open("second").identity.fingerprint)
        assertNotEquals(first, KeyFolder(parent.resolve("c")).open("first").identity.fingerprint)
        assertEquals(listOf("device.p12"), folder.listDirectoryEntries().map { it.name })
        val permissions = PosixFilePermissions.toString(folder.resolve("device.p12").getPosixFilePermissions())
        assertEquals("rw-------", permissions)
        assertEquals("rwx------", PosixFilePermissions.toString(folder.getPosixFilePermissions()))
    }
}
