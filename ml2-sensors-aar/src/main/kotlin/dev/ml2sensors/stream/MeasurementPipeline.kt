package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.Detection3DArray
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Imu
import dev.ml2sensors.message.Joy
import dev.ml2sensors.message.MagneticField
import dev.ml2sensors.message.PoseArray
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.toPose
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ImuUnit
import dev.ml2sensors.source.InertialSample
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.ScalarSample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow
import kotlinx.serialization.SerializationStrategy

/** Publishes a stream with one small message per sample, on one channel. */
internal class MeasurementPipeline(
    private val spec: StreamSpec,
    private val values: StreamValues,
    private val channel: TopicChannel,
    private val stamps: StampMap,
    private val frameIds: FrameIds,
) {
    /** Runs until [samples] end or fail. */
    suspend fun run(samples: Flow<Sample>) {
        samples.collect { sample ->
            when (sample) {
                is VectorSample -> vector(sample)

                is ScalarSample -> publish(sample, ScalarMessage.serializer()) {
                    ScalarMessage(it, sample.value, variance = 0.0)
                }

                is PoseSample -> sample.pose?.let { pose ->
                    publish(sample, PoseStamped.serializer()) { PoseStamped(it, pose.toPose()) }
                }

                is PosesSample -> publish(sample, PoseArray.serializer()) { PoseArray(it, sample.poses) }

                is MarkersSample -> publish(sample, Detection3DArray.serializer()) { sample.toMessage(it, frameIds) }

                is InputSample -> publish(sample, Joy.serializer()) { sample.toMessage(it) }

                is BatterySample -> publish(sample, BatteryState.serializer()) { sample.toMessage(it) }

                is InertialSample -> publish(sample, Imu.serializer()) {
                    imu(it, sample.angularVelocity, sample.linearAcceleration)
                }

                is LostSamples -> channel.counters.countLost(sample.count, sample.reason)

                else -> error("$spec delivered $sample")
            }
        }
    }

    private suspend fun vector(sample: VectorSample) =
        when {
            ImuUnit.entries.any { it.gyroscope == spec } ->
                publish(sample, Imu.serializer()) { imu(it, angularVelocity = sample, linearAcceleration = null) }

            ImuUnit.entries.any { it.accelerometer == spec } ->
                publish(sample, Imu.serializer()) { imu(it, angularVelocity = null, linearAcceleration = sample) }

            else -> publish(sample, MagneticField.serializer()) {
                MagneticField(it, sample.toVector3(), UNKNOWN_COVARIANCE)
            }
        }

    private fun imu(
        header: Header,
        angularVelocity: VectorSample?,
        linearAcceleration: VectorSample?,
    ): Imu {
        val rateVariance = values.angularVelocityVariance ?: 0.0
        return imuMessage(header, angularVelocity, linearAcceleration, rateVariance, values.accelerationVariance ?: 0.0)
    }

    private suspend inline fun <T> publish(
        sample: Sample,
        serializer: SerializationStrategy<T>,
        message: (Header) -> T,
    ) {
        val stampNanos = stamps.stampNanos(sample.captureNanos)
            ?: return channel.counters.countLost(1, stamps.lossReason(sample.captureNanos))
        channel.publish(serializer, message(Header(Time.ofNanos(stampNanos), frameIds.of(spec))), stampNanos)
    }

    private companion object {
        val UNKNOWN_COVARIANCE = DoubleArray(9)
    }
}
