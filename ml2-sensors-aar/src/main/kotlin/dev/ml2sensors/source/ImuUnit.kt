package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * The inertial units of the headset, each with its streams in the table.
 *
 * @property accelerometer the stream of the accelerometer alone.
 * @property gyroscope the stream of the gyroscope alone.
 * @property combined the stream with both in one message.
 */
internal enum class ImuUnit(
    val accelerometer: StreamSpec,
    val gyroscope: StreamSpec,
    val combined: StreamSpec,
) {
    /** The unit in the left half of the headset. */
    LEFT(StreamTable.accelLeft, StreamTable.gyroLeft, StreamTable.imuLeft),

    /** The unit in the right half of the headset. */
    RIGHT(StreamTable.accelRight, StreamTable.gyroRight, StreamTable.imuRight),

    /** The unit in the compute pack at the belt, which does not move with the head. */
    COMPUTE_PACK(StreamTable.accelComputePack, StreamTable.gyroComputePack, StreamTable.imuComputePack),
}
