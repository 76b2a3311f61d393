package dev.ml2sensors.pairing

import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.transport.Fingerprint
import kotlin.random.Random
import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse

class PairingUriTest {
    private val fingerprint = "0123456789abcdef".repeat(4)
    private val token = "00112233445566778899aabbccddeeff"

    @Test
    fun everyPartIsRead() {
        val hosts = listOf("192.168.1.5" to "192.168.1.5", "desk.local" to "desk.local", "[fd00::7]" to "fd00::7")
        for ((written, host) in hosts) {
            for (port in listOf(1, 7756, 65535)) {
                val uri = PairingUri.parse("ml2s://$written:$port?fp=$fingerprint&token=$token")
                assertEquals(ReceiverAddress(host, port, Fingerprint(fingerprint)), uri.receiver)
                assertEquals(token, uri.token)
            }
        }
    }

    @Test
    fun itsTextKeepsTheTokenSecret() {
        val text = "${PairingUri.parse("ml2s://[::1]:7?fp=$fingerprint&token=$token")}"
        assertEquals("ml2s://[::1]:7?fp=$fingerprint", text)
    }

    @Test
    fun anythingElseIsRefusedAndNotRepeated() {
        val good = "ml2s://desk:7756?fp=$fingerprint&token=$token"
        val wrong = listOf(
            "", " $good", "$good\n", "$good&more=1", "$good#x", good.uppercase(), good.replace("ml2s", "http"),
            good.replace("ml2s://", "ml2s:"), good.replace(":7756", ""), good.replace(":7756", ":0"),
            good.replace(
                ":7756",
                ":65536",
            ),
            good.replace(":7756", ":-1"), good.replace(":7756", ":99999999999"), good.replace(":7756", ":07756"),
            good.replace(":7756", ":7756/"), good.replace("desk", ""), good.replace("desk", "de sk"),
            good.replace("desk", "user@desk"), good.replace("desk", "fd00::7"), good.replace("desk", "[desk]"),
            good.replace("desk", "[]"), good.replace("desk", "[1234]"), good.replace("desk", "a".repeat(254)),
            good.replace("desk", "d\u00e9sk"), good.replace(fingerprint, fingerprint.dropLast(1)),
            good.replace(fingerprint, "${fingerprint}0"), good.replace(fingerprint, fingerprint.uppercase()),
            good.replace(
                token,
                token.dropLast(1),
            ),
            good.replace(token, "${token}0"), good.replace(token, "g".repeat(32)),
            "ml2s://desk:7756?token=$token&fp=$fingerprint", "ml2s://desk:7756?fp=$fingerprint", "ml2s://desk:7756",
        )
        for (text in wrong) {
            val failure = assertFailsWith<IllegalArgumentException>(text) { PairingUri.parse(text) }
            assertFalse(token.dropLast(1) in failure.message.orEmpty(), "the token shows in $failure")
        }
    }

    @Test
    fun whatIsReadIsWhatWasWritten() {
        val random = Random(1)
        repeat(2_000) {
            val host = List(random.nextInt(1, 30)) {
                "abcdefghijklmnopqrstuvwxyz0123456789.-".random(random)
            }.joinToString("")
            val port = random.nextInt(1, 65536)
            val fp = random.nextBytes(32).toHexString()
            val secret = random.nextBytes(16).toHexString()
            val uri = PairingUri.parse("ml2s://$host:$port?fp=$fp&token=$secret")
            assertEquals(ReceiverAddress(host, port, Fingerprint(fp)) to secret, uri.receiver to uri.token)
        }
    }

    @Test
    fun aMutationIsRefusedOrReadToItsLastCharacter() {
        val good = "ml2s://desk:7756?fp=$fingerprint&token=$token"
        val random = Random(2)
        repeat(5_000) {
            val at = random.nextInt(good.length)
            val other = good.replaceRange(at, at + random.nextInt(0, 2), random.nextInt(32, 127).toChar().toString())
            val uri = try {
                PairingUri.parse(other)
            } catch (_: IllegalArgumentException) {
                return@repeat
            }
            assertEquals(other, "$uri&token=${uri.token}", "nothing is passed over")
        }
    }
}
