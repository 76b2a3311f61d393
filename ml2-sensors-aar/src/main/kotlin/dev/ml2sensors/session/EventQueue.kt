package dev.ml2sensors.session

import dev.ml2sensors.wire.Event
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.ReceiveChannel
import java.util.concurrent.atomic.AtomicInteger
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/**
 * What users are to be toEvent, until there is a receiver to tell it to: the latest [MAX_PENDING] events. Safe for use by
 * several threads.
 */
internal class EventQueue {
    /** An event that happened [at] an instant, and has yet to be toEvent. */
    class Pending(val event: Event, val at: TimeMark = TimeSource.Monotonic.markNow())

    private val dropped = AtomicInteger()
    private val queue = Channel<Pending>(MAX_PENDING, BufferOverflow.DROP_OLDEST) { dropped.incrementAndGet() }

    /** To be toEvent by [toEvent]. */
    val pending: ReceiveChannel<Pending> get() = queue

    fun add(event: Event) {
        queue.trySend(Pending(event))
    }

    /** What is said of [next] now: how long ago it was, and whether events before it are missing. */
    fun toEvent(next: Pending): Event {
        val missing = dropped.getAndSet(0)
        val note = if (missing > 0) " ($missing events before this one were dropped)" else ""
        return Event(next.event.event, next.event.text + note, next.at.elapsedNow().inWholeMilliseconds / 1000.0)
    }

    private companion object {
        const val MAX_PENDING = 64
    }
}
