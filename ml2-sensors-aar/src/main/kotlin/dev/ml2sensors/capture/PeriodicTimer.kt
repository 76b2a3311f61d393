package dev.ml2sensors.capture

import java.util.concurrent.locks.LockSupport

/** Instants [periodNanos] apart by the clock [now], from now on. Used by one thread. */
internal class PeriodicTimer(
    private val periodNanos: Long,
    private val now: () -> Long,
    private val park: (nanos: Long) -> Unit = LockSupport::parkNanos,
) {
    private var nextNanos = now()

    /** Waits for the next instant; returns how many have passed since the last one without being waited for. */
    fun awaitNext(): Int {
        val missed = ((now() - nextNanos) / periodNanos).coerceIn(0, Int.MAX_VALUE.toLong())
        nextNanos += missed * periodNanos
        while (now() < nextNanos) park(nextNanos - now())
        nextNanos += periodNanos
        return missed.toInt()
    }
}
