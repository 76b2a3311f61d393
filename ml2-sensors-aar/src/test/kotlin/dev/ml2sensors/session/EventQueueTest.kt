package dev.ml2sensors.session

import dev.ml2sensors.wire.Event
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

class EventQueueTest {
    private val queue = EventQueue()
    private val sent = mutableListOf<String>()

    private fun send(limit: Int = Int.MAX_VALUE) = runBlocking {
        queue.sendUntil(CompletableDeferred(Unit)) {
            if (sent.size == limit) throw IOException("the link died")
            sent += it.text
        }
    }

    private fun add(text: String) = queue.add(Event("tracking", text, 0.0))

    @Test
    fun anEventThatCannotBeSentIsSentFirstInTheNextSession() {
        listOf("lost", "recovered", "lost again").forEach(::add)
        assertFailsWith<IOException> { send(limit = 1) }
        add("recovered again")
        send()
        assertEquals(listOf("lost", "recovered", "lost again", "recovered again"), sent)
    }

    @Test
    fun whatIsDroppedIsSaidThoughTheFirstAttemptToSayItFails() {
        repeat(70) { add("event $it") }
        assertFailsWith<IOException> { send(limit = 0) }
        send()
        assertEquals("event 6 (6 events before this one were dropped)", sent.first())
        assertEquals(64, sent.size)
        assertEquals("event 69", sent.last())
    }
}
