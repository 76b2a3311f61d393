package dev.ml2sensors.simulator.signal

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withTimeoutOrNull
import kotlin.time.Duration.Companion.nanoseconds

internal const val NANOS_PER_SECOND: Long = 1_000_000_000

/** The instants start + tick / rate in exact integers: nothing adds up, and equal rates share every instant. */
internal class Ticks(private val startNanos: Long, private val rateHz: Int) {
    fun nanos(tick: Long): Long = startNanos + tick * NANOS_PER_SECOND / rateHz

    /** The last tick that is not after [nanos]; negative before the start. */
    fun lastAt(nanos: Long): Long = Math.floorDiv((nanos - startNanos + 1) * rateHz - 1, NANOS_PER_SECOND)

    fun seconds(tick: Long): Double = tick.toDouble() / rateHz
}

/** One reading to be taken: its [number] since the sensor was switched on, and [seconds] since the headset began. */
internal class Capture(val number: Long, val nanos: Long, val seconds: Double)

/** A sensor's readings: [rateHz] of them a second, each a function of its capture alone. */
internal class Signal(val rateHz: Int, val read: (Capture) -> Sample)

/** How long a reading waits for a late reader, as it does in the queues of a device, before it is lost. */
internal const val KEPT_NANOS = 250_000_000L

/** The readings of every tick from now on, each after its instant, until the [end]; images are lent. */
internal fun Signal.readings(clock: DeviceClock, startNanos: Long, end: Job): Flow<Sample> = flow {
    val ticks = Ticks(startNanos, rateHz)
    val first = maxOf(0, ticks.lastAt(clock.nowNanos() - 1) + 1)
    var tick = first
    while (clock.reaches(ticks.nanos(tick), end)) {
        val now = clock.nowNanos()
        val lost = if (now - ticks.nanos(tick) > KEPT_NANOS) ticks.lastAt(now) - tick else 0
        if (lost > 0) emit(LostSamples(ticks.nanos(tick), lost.toInt(), DropReason.SOURCE_LATE))
        tick += lost
        lend(read(Capture(tick - first, ticks.nanos(tick), ticks.seconds(tick))))
        tick++
    }
}

/** Whether [dueNanos] comes before the [end]. */
internal suspend fun DeviceClock.reaches(dueNanos: Long, end: Job): Boolean {
    while (end.isActive) {
        val wait = dueNanos - nowNanos()
        if (wait <= 0) return true
        withTimeoutOrNull(wait.nanoseconds) { end.join() }
    }
    return false
}

internal suspend fun FlowCollector<Sample>.lend(sample: Sample) = try {
    emit(sample)
} finally {
    (sample as? ImageSample)?.release()
}
