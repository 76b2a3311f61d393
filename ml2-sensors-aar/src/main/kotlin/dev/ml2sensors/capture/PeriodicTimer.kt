package dev.ml2sensors.capture

import java.util.concurrent.locks.LockSupport

/**
 * Waits for instants [periodNanos] apart by the clock [now]. Those that pass while the device is suspended are not
 * missed. Used by one thread.
 *
 * @param suspendedNanos returns how long the device has been suspended, which [now] includes.
 */
internal class PeriodicTimer(
    private val periodNanos: Long,
    private val now: () -> Long,
    private val suspendedNanos: () -> Long = { 0 },
    private val park: (nanos: Long) -> Unit = LockSupport::parkNanos,
) {
    private var suspendedBeforeNanos = suspendedNanos()
    private var nextNanos = now()

    /** True if the device was suspended for at least a period before the last instant. */
    var wasSuspended: Boolean = false
        private set

    /** Waits for the next instant. Returns how many instants were missed since the last one. */
    fun awaitNext(): Int {
        val suspended = suspendedNanos() - suspendedBeforeNanos
        wasSuspended = suspended >= periodNanos
        if (wasSuspended) {
            suspendedBeforeNanos += suspended
            nextNanos += suspended
        }
        val missed = ((now() - nextNanos) / periodNanos).coerceIn(0, Int.MAX_VALUE.toLong())
        nextNanos += missed * periodNanos
        while (now() < nextNanos) park(nextNanos - now())
        nextNanos += periodNanos
        return missed.toInt()
    }
}
