package dev.ml2sensors.source

import kotlinx.coroutines.channels.ReceiveChannel
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.buffer
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.produceIn

/**
 * Every reading of [gyroscope], in order and none merged, with the acceleration interpolated to its instant. Readings
 * before the first or after the last acceleration have none and are left out: it is never extrapolated. Elements are
 * [InertialSample]s, and the gyroscope's [LostSamples].
 */
internal fun pairInertial(
    gyroscope: Flow<Sample>,
    accelerometer: Flow<Sample>,
): Flow<Sample> =
    flow {
        coroutineScope {
            val accelerations = accelerometer.filterIsInstance<VectorSample>().buffer(READ_AHEAD).produceIn(this)
            val bracket = Bracket(accelerations)
            gyroscope.buffer(READ_AHEAD).collect { rate ->
                when (rate) {
                    is VectorSample -> bracket.at(rate.captureNanos)?.let { emit(InertialSample(rate, it)) }
                    is LostSamples -> emit(rate)
                    else -> error("a gyroscope delivers vectors, not $rate")
                }
            }
            accelerations.cancel()
        }
    }

/** The two accelerations around an instant that only grows. */
private class Bracket(
    private val accelerations: ReceiveChannel<VectorSample>,
) {
    private var before: VectorSample? = null
    private var after: VectorSample? = null

    /** The acceleration at [nanos], null outside of what was measured. */
    suspend fun at(nanos: Long): VectorSample? {
        while ((after?.captureNanos ?: Long.MIN_VALUE) < nanos) {
            before = after
            after = accelerations.receiveCatching().getOrNull() ?: return null
        }
        val end = after ?: return null
        if (end.captureNanos == nanos) return end
        return before?.let { interpolate(it, end, nanos) }
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

/** Enough for either sensor to run ahead by what an operating system delivers in one batch. */
private const val READ_AHEAD = 64
