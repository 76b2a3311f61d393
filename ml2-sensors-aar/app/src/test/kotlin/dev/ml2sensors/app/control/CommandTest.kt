package dev.ml2sensors.app.control

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertIs

class CommandTest {
    @Test
    fun everyActionIsParsed() {
        assertEquals(Command.Resume, parse(null))
        assertEquals(Command.Start, parse("dev.ml2sensors.app.START"))
        assertEquals(Command.Stop, parse("dev.ml2sensors.app.STOP"))
        assertEquals(Command.Status, parse("dev.ml2sensors.app.STATUS"))
        assertEquals(Command.SetStartAtBoot(true), parse("dev.ml2sensors.app.AT_BOOT", "on" to true))
        assertEquals(Command.SetPauseWhenHot(false), parse("dev.ml2sensors.app.COOL_DOWN", "on" to false))
        for (receiver in listOf("", "desk", "127.0.0.1:7755")) {
            assertEquals(Command.SetReceiver(receiver), parse("dev.ml2sensors.app.RECEIVER", "receiver" to receiver))
        }
        assertEquals(URI, assertIs<Command.Pair>(parse("dev.ml2sensors.app.PAIR", "uri" to URI)).uri)
    }

    @Test
    fun invalidIntentsAreRefusedWithWhatWasExpected() {
        refused("there is no action android.intent.action.VIEW", "android.intent.action.VIEW")
        refused("expected the extra --es uri TEXT", "dev.ml2sensors.app.PAIR")
        refused("expected the extra --es uri TEXT", "dev.ml2sensors.app.PAIR", "uri" to 7)
        refused("expected the extra --es receiver TEXT", "dev.ml2sensors.app.RECEIVER")
        refused("expected a name, or HOST:PORT", "dev.ml2sensors.app.RECEIVER", "receiver" to "desk:0")
        refused("expected the extra --ez on true or false", "dev.ml2sensors.app.AT_BOOT", "on" to "yes")
    }

    @Test
    fun anInvalidPairingUriIsNotRepeatedInTheError() {
        val message = refused("expected ml2s://", "dev.ml2sensors.app.PAIR", "uri" to URI + "0")
        assertFalse(TOKEN in message, message)
    }

    private fun refused(message: String, action: String, vararg extras: Pair<String, Any>): String {
        val failure = assertFailsWith<IllegalArgumentException> { parse(action, *extras) }
        return failure.message.orEmpty().also { assertEquals(message, it.take(message.length)) }
    }

    private fun parse(action: String?, vararg extras: Pair<String, Any>) = Command.parse(action, mapOf(*extras)::get)

    private companion object {
        val TOKEN = "5".repeat(32)
        val URI = "ml2s://10.0.0.2:7756?fp=${"a".repeat(64)}&token=$TOKEN"
    }
}
