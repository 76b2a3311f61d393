package dev.ml2sensors.session

import dev.ml2sensors.wire.Event
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.ReceiveChannel
import java.util.concurrent.atomic.AtomicInteger
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/** The latest [MAX_PENDING] events until they can be sent to a receiver. Thread-safe. */
internal class EventQueue {
    /** An event that happened [at] an instant and was not sent yet. */
    class Pending(val event: Event, val at: TimeMark = TimeSource.Monotonic.markNow())

    private val dropped = AtomicInteger()
    private val queue = Channel<Pending>(MAX_PENDING, BufferOverflow.DROP_OLDEST) { dropped.incrementAndGet() }

    /** The events to send, each with [toEvent]. */
    val pending: ReceiveChannel<Pending> get() = queue

    fun add(event: Event) {
        queue.trySend(Pending(event))
    }

    /** Returns the event to send now, with its age and a note if earlier events were dropped. */
    fun toEvent(next: Pending): Event {
        val missing = dropped.getAndSet(0)
        val note = if (missing > 0) " ($missing events before this one were dropped)" else ""
        return Event(next.event.event, next.event.text + note, next.at.elapsedNow().inWholeMilliseconds / 1000.0)
    }

    private companion object {
        const val MAX_PENDING = 64
    }
}
