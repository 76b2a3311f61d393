package dev.ml2sensors.capture

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.URGENT_PRIORITY
import dev.ml2sensors.source.imagePriority
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.withTimeoutOrNull
import java.util.concurrent.locks.ReentrantLock
import kotlin.concurrent.withLock
import kotlin.time.Duration.Companion.seconds

/** One collector of one stream. */
internal class Subscription(val stream: StreamSpec, val values: StreamValues, val queue: SampleQueue)

/** An open sensor, used by its [SensorThread] and ended by [close]. */
internal interface OpenSensor {
    /** Switches to [subscriptions]; if it throws, the previous ones continue. */
    fun configure(subscriptions: List<Subscription>)

    /** Waits for the next capture, for 0.1 s at most, and delivers it to [subscriptions]. */
    fun deliver(subscriptions: List<Subscription>)

    fun close()
}

/**
 * The thread that owns one sensor, since native handles belong to a thread. It opens the sensor for the first
 * subscription, configures it as subscriptions come and go, and closes it after the last one or for a pause. A failure
 * ends the subscriptions that it occurred for. Its methods may be called from any other thread.
 *
 * @param isUrgent if images must not delay it.
 */
internal class SensorThread(
    name: String,
    isUrgent: Boolean,
    private val open: (List<Subscription>) -> OpenSensor,
) : AutoCloseable {
    private class DesiredState(
        val version: Long = 0,
        val subscriptions: List<Subscription> = emptyList(),
        val isPaused: Boolean = false,
        val isClosed: Boolean = false,
    ) {
        val running: List<Subscription> get() = if (isPaused) emptyList() else subscriptions
    }

    private val lock = ReentrantLock()
    private val changed = lock.newCondition()
    private val thread = Thread(::run, name).apply {
        isDaemon = true
        priority = if (isUrgent) URGENT_PRIORITY else imagePriority
    }
    private val appliedVersion = MutableStateFlow(0L)
    private var desired = DesiredState()

    // Only the thread reads and writes these
    private var sensor: OpenSensor? = null
    private var running = emptyList<Subscription>()

    /** True while the vendor has not returned from a call that [unsubscribe] has waited for. */
    @Volatile
    private var isStuck = false

    /** The first reason for which the sensor is to be closed, until it is. */
    @Volatile
    private var failure: Throwable? = null

    /**
     * @param admit throws when [subscription] cannot run beside the others.
     * @throws CaptureException.VendorFailure while the vendor does not return.
     */
    fun subscribe(subscription: Subscription, admit: (others: List<Subscription>) -> Unit) {
        lock.withLock {
            check(!desired.isClosed) { "${thread.name} is closed" }
            if (isStuck) throw stuck()
            admit(desired.subscriptions)
            change { DesiredState(it.version + 1, it.subscriptions + subscription, it.isPaused) }
        }
    }

    /** Returns when the sensor runs, or is closed, without [subscription], or when the vendor does not return. */
    suspend fun unsubscribe(subscription: Subscription) {
        val version = change { DesiredState(it.version + 1, it.subscriptions - subscription, it.isPaused) }
        if (isStuck) return
        withTimeoutOrNull(LIMIT) { appliedVersion.first { it >= version } } ?: lock.withLock {
            isStuck = appliedVersion.value < version
        }
    }

    private fun stuck(): CaptureException {
        val left = "the vendor's library has not returned to the thread '${thread.name}'; the sensor is used again " +
            "when it does; if that lasts, restart the headset"
        return CaptureException.VendorFailure(listOfNotNull(failure?.message, left).joinToString("; "))
    }

    fun pause(isPaused: Boolean) {
        change { DesiredState(it.version + 1, it.subscriptions, isPaused) }
    }

    /** Ends all subscriptions and returns when the sensor is closed, after [LIMIT] at most. */
    override fun close() {
        lock.withLock {
            desired.subscriptions.forEach { it.queue.close(cause = null) }
            change { DesiredState(it.version + 1, isClosed = true) }
        }
        thread.join(LIMIT.inWholeMilliseconds)
    }

    /** Applies [next], unless the thread is closed; returns the new version. */
    private fun change(next: (DesiredState) -> DesiredState): Long = lock.withLock {
        if (!desired.isClosed) desired = next(desired)
        if (thread.state == Thread.State.NEW) thread.start()
        changed.signal()
        desired.version
    }

    private fun run() {
        do {
            val next = awaitWork()
            if (next.version != appliedVersion.value) apply(next)
            try {
                sensor?.deliver(running)
            } catch (e: Throwable) {
                failure = e
                end(running, e)
                closeSensor()
            }
        } while (!next.isClosed)
    }

    private fun awaitWork(): DesiredState = lock.withLock {
        while (sensor == null && desired.version == appliedVersion.value) changed.await()
        desired
    }

    private fun apply(next: DesiredState) {
        val newcomers = next.running - running.toSet()
        try {
            switchTo(next.running)
        } catch (e: Throwable) {
            end(newcomers.ifEmpty { running }, e)
            if (newcomers.isEmpty()) closeSensor()
        }
        lock.withLock {
            appliedVersion.value = next.version
            isStuck = false
            failure = null
        }
    }

    private fun switchTo(subscriptions: List<Subscription>) {
        if (subscriptions.isEmpty()) return closeSensor()
        sensor?.configure(subscriptions) ?: run { sensor = open(subscriptions) }
        running = subscriptions
    }

    private fun closeSensor() {
        sensor?.close()
        sensor = null
        running = emptyList()
    }

    private fun end(subscriptions: List<Subscription>, cause: Throwable) {
        change { DesiredState(it.version + 1, it.subscriptions - subscriptions.toSet(), it.isPaused) }
        subscriptions.forEach { it.queue.close(cause) }
    }

    private companion object {
        /** Many times what a vendor's camera takes to open or close. */
        val LIMIT = 3.seconds
    }
}
