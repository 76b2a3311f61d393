package dev.ml2sensors.source

import kotlinx.coroutines.channels.ReceiveChannel
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.buffer
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.produceIn

/**
 * Pairs every reading of [gyroscope], in order, with the acceleration interpolated to its time. Accelerations are never
 * extrapolated: pairs begin with the first one, and a reading after the last one is lost as [DropReason.SOURCE_LATE].
 * Elements are [InertialSample]s, and the [LostSamples] of both sensors.
 */
internal fun joinInertial(
    gyroscope: Flow<Sample>,
    accelerometer: Flow<Sample>,
): Flow<Sample> =
    flow {
        coroutineScope {
            val accelerations = accelerometer.buffer(READ_AHEAD).produceIn(this)
            val bracket = Bracket(accelerations) { emit(it) }
            gyroscope.collect { rate ->
                when (rate) {
                    is VectorSample -> {
                        val acceleration = bracket.at(rate.captureNanos)
                        if (acceleration != null) emit(InertialSample(rate, acceleration))
                        if (bracket.isOver) emit(LostSamples(rate.captureNanos, 1, DropReason.SOURCE_LATE))
                    }

                    is LostSamples -> emit(rate)

                    else -> error("a gyroscope delivers vectors, not $rate")
                }
            }
            accelerations.cancel()
        }
    }

/** The two accelerations around a time that only increases; losses go to [lose]. */
private class Bracket(
    private val accelerations: ReceiveChannel<Sample>,
    private val lose: suspend (LostSamples) -> Unit,
) {
    private var before: VectorSample? = null
    private var after: VectorSample? = null

    /** True if the time is later than the last acceleration. */
    var isOver = false
        private set

    /** Returns the acceleration at [nanos], or null outside of the measured range. */
    suspend fun at(nanos: Long): VectorSample? {
        while ((after?.captureNanos ?: Long.MIN_VALUE) < nanos) {
            before = after
            after = next() ?: return null.also { isOver = true }
        }
        val end = after ?: return null
        if (end.captureNanos == nanos) return end
        return before?.let { interpolate(it, end, nanos) }
    }

    private suspend fun next(): VectorSample? {
        while (true) {
            when (val sample = accelerations.receiveCatching().getOrNull() ?: return null) {
                is VectorSample -> return sample
                is LostSamples -> lose(sample)
                else -> error("an accelerometer delivers vectors, not $sample")
            }
        }
    }
}

private fun interpolate(
    a: VectorSample,
    b: VectorSample,
    nanos: Long,
): VectorSample {
    val fraction = (nanos - a.captureNanos).toDouble() / (b.captureNanos - a.captureNanos)
    return VectorSample(
        nanos,
        a.x + fraction * (b.x - a.x),
        a.y + fraction * (b.y - a.y),
        a.z + fraction * (b.z - a.z),
    )
}

/** Covers what an operating system delivers in one batch. The queues of sensors let the gyroscope run ahead. */
private const val READ_AHEAD = 64
