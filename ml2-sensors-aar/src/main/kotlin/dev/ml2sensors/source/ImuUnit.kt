package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * The inertial units of the headset, each with its streams in the table.
 *
 * @property accelerometer by itself.
 * @property gyroscope by itself.
 * @property united both in one message.
 */
public enum class ImuUnit(
    public val accelerometer: StreamSpec,
    public val gyroscope: StreamSpec,
    public val united: StreamSpec,
) {
    /** In the left half of the headset. */
    LEFT(StreamTable.accelLeft, StreamTable.gyroLeft, StreamTable.imuLeft),

    /** In the right half of the headset. */
    RIGHT(StreamTable.accelRight, StreamTable.gyroRight, StreamTable.imuRight),

    /** In the pack at the belt: it does not move with the head. */
    COMPUTE_PACK(StreamTable.accelComputePack, StreamTable.gyroComputePack, StreamTable.imuComputePack),
}
