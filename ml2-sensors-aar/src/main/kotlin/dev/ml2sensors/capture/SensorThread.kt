package dev.ml2sensors.capture

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import java.util.concurrent.locks.ReentrantLock
import kotlin.concurrent.withLock

/** One collector of one stream. */
internal class Subscription(val stream: StreamSpec, val values: StreamValues, val queue: SampleQueue)

/** An opened sensor as its thread sees it; ended by [close]. */
internal interface OpenSensor {
    /** Other [subscriptions]; the old ones go on when it throws. */
    fun configure(subscriptions: List<Subscription>)

    /** Waits for the next capture, a tenth of a second at most, and hands it to [subscriptions]. */
    fun deliver(subscriptions: List<Subscription>)

    fun close()
}

/**
 * The one thread that owns a sensor, as its handle demands: opens it for the first subscription, configures it as they
 * come and go, closes it after the last one or for a pause, and sleeps meanwhile. What fails ends the subscriptions it
 * was done for. Its methods may be called from any other thread.
 */
internal class SensorThread(
    name: String,
    private val open: (List<Subscription>) -> OpenSensor,
) : AutoCloseable {
    private class Wanted(
        val version: Long = 0,
        val subscriptions: List<Subscription> = emptyList(),
        val isPaused: Boolean = false,
        val isClosed: Boolean = false,
    ) {
        val running: List<Subscription> get() = if (isPaused) emptyList() else subscriptions
    }

    private val lock = ReentrantLock()
    private val changed = lock.newCondition()
    private val thread = Thread(::run, name).apply { isDaemon = true }
    private val appliedVersion = MutableStateFlow(0L)
    private var wanted = Wanted()

    // Of the thread alone
    private var sensor: OpenSensor? = null
    private var running = emptyList<Subscription>()

    /** @param admit throws when [subscription] cannot run beside the others. */
    fun subscribe(subscription: Subscription, admit: (others: List<Subscription>) -> Unit) {
        lock.withLock {
            check(!wanted.isClosed) { "${thread.name} is closed" }
            admit(wanted.subscriptions)
            change { Wanted(it.version + 1, it.subscriptions + subscription, it.isPaused) }
        }
    }

    /** Returns when the sensor runs, or is closed, without [subscription]. */
    suspend fun unsubscribe(subscription: Subscription) {
        val version = change { Wanted(it.version + 1, it.subscriptions - subscription, it.isPaused) }
        appliedVersion.first { it >= version }
    }

    fun pause(isPaused: Boolean) {
        change { Wanted(it.version + 1, it.subscriptions, isPaused) }
    }

    /** Ends all subscriptions and returns when the sensor is closed. */
    override fun close() {
        lock.withLock {
            wanted.subscriptions.forEach { it.queue.close(cause = null) }
            change { Wanted(it.version + 1, isClosed = true) }
        }
        thread.join()
    }

    /** Returns the version that it makes; a closed thread changes no more. */
    private fun change(next: (Wanted) -> Wanted): Long = lock.withLock {
        if (!wanted.isClosed) wanted = next(wanted)
        if (thread.state == Thread.State.NEW) thread.start()
        changed.signal()
        wanted.version
    }

    private fun run() {
        do {
            val next = awaitWork()
            if (next.version != appliedVersion.value) apply(next)
            try {
                sensor?.deliver(running)
            } catch (e: Throwable) {
                end(running, e)
                closeSensor()
            }
        } while (!next.isClosed)
    }

    private fun awaitWork(): Wanted = lock.withLock {
        while (sensor == null && wanted.version == appliedVersion.value) changed.await()
        wanted
    }

    private fun apply(next: Wanted) {
        val newcomers = next.running - running.toSet()
        try {
            switchTo(next.running)
        } catch (e: Throwable) {
            end(newcomers.ifEmpty { running }, e)
            if (newcomers.isEmpty()) closeSensor()
        }
        appliedVersion.value = next.version
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
        change { Wanted(it.version + 1, it.subscriptions - subscriptions.toSet(), it.isPaused) }
        subscriptions.forEach { it.queue.close(cause) }
    }
}
