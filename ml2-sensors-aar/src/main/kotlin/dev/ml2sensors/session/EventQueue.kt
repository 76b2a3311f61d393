package dev.ml2sensors.session

import dev.ml2sensors.wire.Event
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.selects.select
import java.util.concurrent.atomic.AtomicInteger
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/** The latest [MAX_PENDING] events until they can be sent to a receiver. Thread-safe. */
internal class EventQueue {
    /** An event that happened [at] an instant and was not sent yet. */
    private class Pending(val event: Event, val at: TimeMark = TimeSource.Monotonic.markNow())

    private val dropped = AtomicInteger()
    private val queue = Channel<Pending>(MAX_PENDING, BufferOverflow.DROP_OLDEST) { dropped.incrementAndGet() }

    /** The event that was taken from [queue] and is not known to be sent. */
    @Volatile
    private var unsent: Pending? = null

    fun add(event: Event) {
        queue.trySend(Pending(event))
    }

    /**
     * Passes events to [send], the oldest first, until [end] completes and nothing is pending. An event whose sending
     * fails is the first one of the next call. Called by one coroutine at a time.
     */
    suspend fun sendUntil(end: Deferred<Unit>, send: suspend (Event) -> Unit) {
        while (true) {
            val next = unsent ?: select<Pending?> {
                queue.onReceive { it }
                end.onAwait { null }
            } ?: return
            unsent = next
            val missing = dropped.get()
            send(next.toEvent(missing))
            dropped.addAndGet(-missing)
            unsent = null
        }
    }

    /** Returns the event with its age, and a note if [missing] earlier events were dropped. */
    private fun Pending.toEvent(missing: Int): Event {
        val note = if (missing > 0) " ($missing events before this one were dropped)" else ""
        return Event(event.event, event.text + note, at.elapsedNow().inWholeMilliseconds / 1000.0)
    }

    private companion object {
        const val MAX_PENDING = 64
    }
}
