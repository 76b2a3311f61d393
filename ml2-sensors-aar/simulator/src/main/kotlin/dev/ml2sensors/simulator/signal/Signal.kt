package dev.ml2sensors.simulator.signal

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.selects.onTimeout
import kotlinx.coroutines.selects.select
import kotlin.time.Duration.Companion.nanoseconds

internal const val NANOS_PER_SECOND: Long = 1_000_000_000

/** The sample times start + tick / rate, in exact integers: errors do not accumulate, and equal rates share all times. */
internal class SampleTimes(private val startNanos: Long, private val rateHz: Int) {
    fun nanos(tick: Long): Long = startNanos + tick * NANOS_PER_SECOND / rateHz

    /** Returns the last tick that is not after [nanos]; negative before the start. */
    fun lastTickAt(nanos: Long): Long = Math.floorDiv((nanos - startNanos + 1) * rateHz - 1, NANOS_PER_SECOND)

    fun seconds(tick: Long): Double = tick.toDouble() / rateHz
}

/** The time of one sample: its [number] since the sensor was started, and [seconds] since the headset was. */
internal class Capture(val number: Long, val nanos: Long, val seconds: Double)

/** A sensor that delivers [rateHz] samples per second, each a function of its capture alone. */
internal class Signal(val rateHz: Int, val read: (Capture) -> Sample)

/** The longest time that a sample waits for a late collector before it is lost, as in the queues of a device. */
internal const val MAX_LATENESS_NANOS = 250_000_000L

/** Emits the sample of every tick from now on, each after its capture time, until [end]. Releases images after use. */
internal fun Signal.samples(clock: DeviceClock, startNanos: Long, end: Job): Flow<Sample> = flow {
    val ticks = SampleTimes(startNanos, rateHz)
    val first = maxOf(0, ticks.lastTickAt(clock.nowNanos() - 1) + 1)
    var tick = first
    while (clock.waitUntil(ticks.nanos(tick), end)) {
        val now = clock.nowNanos()
        val lost = if (now - ticks.nanos(tick) > MAX_LATENESS_NANOS) ticks.lastTickAt(now) - tick else 0
        if (lost > 0) emit(LostSamples(ticks.nanos(tick), lost.toInt(), DropReason.SOURCE_LATE))
        tick += lost
        emitAndRelease(read(Capture(tick - first, ticks.nanos(tick), ticks.seconds(tick))))
        tick++
    }
}

/** Waits until [dueNanos], which costs no exception as withTimeout() would. Returns false if [end] came first. */
@OptIn(ExperimentalCoroutinesApi::class)
internal suspend fun DeviceClock.waitUntil(dueNanos: Long, end: Job): Boolean {
    while (end.isActive) {
        val wait = dueNanos - nowNanos()
        if (wait <= 0) return true
        select {
            end.onJoin {}
            onTimeout(wait.nanoseconds) {}
        }
    }
    return false
}

internal suspend fun FlowCollector<Sample>.emitAndRelease(sample: Sample) = try {
    emit(sample)
} finally {
    (sample as? ImageSample)?.release()
}
