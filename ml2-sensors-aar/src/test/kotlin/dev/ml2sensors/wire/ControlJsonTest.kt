package dev.ml2sensors.wire

import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertIs
import kotlin.test.assertNull
import kotlin.test.assertTrue

class ControlJsonTest {
    private val welcome =
        """{"version": 1, "session": "5e", "name": "Größe \ud83d\ude00", "software": "x",
           "tickets": {"time": "a", "sensors": "b"}, "received": {"/tf": 7}, "limits": {"data_bytes": 3000000000},
           "timeouts": {"handshake_s": 5, "ping_s": 0.5, "dead_s": 2e0}}"""

    @Test
    fun bodiesAreReadByTheNamesOfTheProtocol() {
        val read = decode<Welcome>(welcome)
        assertEquals(1, read.version)
        assertEquals("Größe \uD83D\uDE00", read.name)
        assertEquals(mapOf("time" to "a", "sensors" to "b"), read.tickets)
        assertEquals(mapOf("/tf" to 7L), read.received)
        assertEquals(3_000_000_000, read.limits.dataBytes)
        assertEquals(listOf(5.0, 0.5, 2.0), with(read.timeouts) { listOf(handshakeSeconds, pingSeconds, deadSeconds) })
    }

    @Test
    fun bodiesAreWrittenByTheNamesOfTheProtocol() {
        assertEquals("""{"code":"source","message":"ä","fatal":false}""", encoded(ErrorBody("source", "ä", false)))
        assertEquals("""{"session":"s","ticket":"t","lane":"l"}""", encoded(Join("s", "t", "l")))
        val answers = mapOf("tf" to Configured.StreamAnswer("refused", reason = "no"))
        assertEquals(
            """{"request":7,"streams":{"tf":{"result":"refused","reason":"no"}}}""",
            encoded(Configured(7, answers)),
        )
    }

    @Test
    fun unknownKeysAreIgnored() {
        val nested = "[".repeat(15) + "]".repeat(15)
        val bye = decode<Bye>("""{"later": {"a": [1, null, "\"}"]}, "reason": "over", "deep": $nested}""")
        assertEquals("over", bye.reason)
    }

    @Test
    fun receivedIsNullWhenTheInstanceIsUnknown() {
        assertNull(decode<Welcome>(welcome.replace("""{"/tf": 7}""", "null")).received)
    }

    @Test
    fun requestsAreAnyI64() {
        assertEquals(Long.MAX_VALUE, decode<Start>("""{"request": 9223372036854775807}""").request)
        assertMalformed<Start>("""{"request": 9223372036854775808}""")
        assertMalformed<Start>("""{"request": ${"9".repeat(5000)}}""")
    }

    @Test
    fun mistypedValuesAreMalformed() {
        for (value in listOf("\"7\"", "true", "1.0", "1e2", "+1", "01", "null", "[7]", "{}", "NaN")) {
            assertMalformed<Start>("""{"request": $value}""")
        }
        for (value in listOf("\"true\"", "1", "0", "null", "True", "\"\"")) {
            assertMalformed<ErrorBody>("""{"code": "c", "message": "m", "fatal": $value}""")
        }
        for (value in listOf("7", "true", "null", "[]", "abc")) assertMalformed<Bye>("""{"reason": $value}""")
        for (value in listOf("\"2\"", "NaN", "Infinity", "-Infinity", "1e999", "\"NaN\"", ".5", "5.", "0x10")) {
            assertMalformed<Welcome>(welcome.replace("2e0", value))
        }
        for (value in listOf("[]", "\"a\"", "{\"time\": 7}")) {
            assertMalformed<Welcome>(welcome.replace("""{"time": "a", "sensors": "b"}""", value))
        }
    }

    @Test
    fun aBodyIsOneObjectAndNothingElse() {
        val bodies = listOf("", " ", "null", "[]", "7", "\"a\"", "{", "}", "{}{}", """{"reason": "a"} x""")
        val whole = """{"reason": "a"}"""
        for (body in bodies + "$whole\u0000" + "\uFEFF$whole") assertMalformed<Bye>(body)
    }

    @Test
    fun whatIsNotJsonIsMalformedEvenUnderIgnoredKeys() {
        val values = listOf("NaN", "Infinity", "abc", "'a'", "01", "1.", "[1,]", "/**/1")
        val texts = listOf("\\ud800", "\\ud800x", "\\udc00", "\n", "\\x", "\\u12g4")
        for (value in values + texts.map { "\"$it\"" }) assertMalformed<Bye>("""{"reason": "a", "later": $value}""")
        assertMalformed<Bye>("""{"reason": "a", "\udfff": 1}""")
        assertMalformed<Bye>("""{"reason": "a",}""")
        assertMalformed<Bye>("""{'reason': "a"}""")
        assertMalformed<Bye>("""{reason: "a"}""")
    }

    @Test
    fun bodiesAreUtf8() {
        for (bytes in listOf("c3", "c0 80", "ed a0 80", "f8 88 80 80 80", "ff fe")) {
            val text = bytes.split(' ').map { it.toInt(16).toByte() }.toByteArray()
            val body = "{\"reason\": \"".toByteArray() + text + "\"}".toByteArray()
            assertEquals(ErrorCode.MALFORMED, assertFailsWith<ProtocolException> { ControlJson.decode<Bye>(body) }.code)
        }
    }

    @Test
    fun anyBytesAreABodyOrMalformed() {
        val random = Random(20)
        val seeds = listOf(welcome, """{"request": 5, "streams": {"a": {"stream": 0, "format": "x", "flags": true}}}""")
        repeat(20_000) {
            val bytes = seeds[it % 2].toByteArray()
            repeat(random.nextInt(1, 4)) { bytes[random.nextInt(bytes.size)] = TOKENS.random(random).code.toByte() }
            val decoded = runCatching {
                if (it % 2 == 0) ControlJson.decode<Welcome>(bytes) else ControlJson.decode<Configure>(bytes)
            }
            decoded.onFailure { failure -> assertIs<ProtocolException>(failure, bytes.decodeToString()) }
        }
    }

    @Test
    fun errorsFitTheirFrameWhateverTheySay() {
        for (text in listOf("\u0000", "\"", "\uD83D\uDE00", "€", "\uD800")) {
            val body = ControlJson.encode(ErrorBody.of(ErrorCode.SOURCE, text.repeat(10_000), fatal = false))
            assertTrue(body.size <= FrameKind.ERROR.maxLength, "${body.size} bytes")
        }
    }

    private inline fun <reified T> decode(text: String): T = ControlJson.decode(text.toByteArray())

    private inline fun <reified T> encoded(body: T): String = ControlJson.encode(body).decodeToString()

    private inline fun <reified T> assertMalformed(text: String) {
        val error = assertFailsWith<ProtocolException>(text.take(300)) { decode<T>(text) }
        assertEquals(ErrorCode.MALFORMED, error.code)
    }

    private companion object {
        val TOKENS = ("{}[]\",:\\u0d8 \n\t-+.eE0179tfnN" + "\u0000\u0080\u00C3\u00FF").toList()
    }
}
