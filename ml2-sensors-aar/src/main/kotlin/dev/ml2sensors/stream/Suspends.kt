package dev.ml2sensors.stream

import dev.ml2sensors.session.EventQueue
import dev.ml2sensors.source.Headset
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.delay
import kotlin.time.Duration
import kotlin.time.Duration.Companion.nanoseconds
import kotlin.time.Duration.Companion.seconds

private val CHECK_INTERVAL = 1.seconds

/** Tells [events] how long the device was suspended, whenever it was for a second or more, until it is cancelled. */
internal suspend fun Headset.reportSuspends(events: EventQueue): Nothing {
    var before = suspendedNanos
    while (true) {
        delay(CHECK_INTERVAL)
        val suspended = (suspendedNanos - before).nanoseconds.inWholeSeconds.seconds
        if (suspended <= Duration.ZERO) continue
        before += suspended.inWholeNanoseconds
        events.add(Event(Event.SUSPENDED, "the headset slept for $suspended"))
    }
}
