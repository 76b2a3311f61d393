package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/** The inertial units of the headset, each with its streams in the table. */
public enum class ImuUnit(
    public val accelerometer: StreamSpec,
    public val gyroscope: StreamSpec,
    public val united: StreamSpec,
) {
    LEFT(StreamTable.accelLeft, StreamTable.gyroLeft, StreamTable.imuLeft),
    RIGHT(StreamTable.accelRight, StreamTable.gyroRight, StreamTable.imuRight),
    COMPUTE_PACK(StreamTable.accelComputePack, StreamTable.gyroComputePack, StreamTable.imuComputePack),
}
