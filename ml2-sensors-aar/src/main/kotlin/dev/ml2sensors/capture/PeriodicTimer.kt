package dev.ml2sensors.capture

import java.util.concurrent.locks.LockSupport

/** Waits for instants [periodNanos] apart by the clock [now]. Used by one thread. */
internal class PeriodicTimer(
    private val periodNanos: Long,
    private val now: () -> Long,
    private val park: (nanos: Long) -> Unit = LockSupport::parkNanos,
) {
    private var nextNanos = now()

    /** Waits for the next instant. Returns how many instants were missed since the last one. */
    fun awaitNext(): Int {
        val missed = ((now() - nextNanos) / periodNanos).coerceIn(0, Int.MAX_VALUE.toLong())
        nextNanos += missed * periodNanos
        while (now() < nextNanos) park(nextNanos - now())
        nextNanos += periodNanos
        return missed.toInt()
    }
}
