package dev.ml2sensors.capture

import dev.ml2sensors.message.Transform

/**
 * Where the colour camera was, for frames that come by another way than the native library, such as Camera2. Opened by
 * the constructor; used and closed by the thread that called it. Fails with [CaptureException].
 */
public class ColorCameraPoses : AutoCloseable {
    private val poses = PoseBlock(1)
    private val handle = NativeSettings(SENSOR_COLOR, NativeBackend.SDK.code, STREAMS).open()

    /**
     * Of the optical frame in the world at [mlTimeNanos], null when not tracked. To be asked as soon as a frame is
     * there: the device remembers its poses for a short time only.
     */
    public fun at(mlTimeNanos: Long): Transform? =
        if (Native.colorPose(handle, mlTimeNanos, poses.memory)) poses[0].pose?.toOptical() else null

    override fun close(): Unit = Native.close(handle)

    private companion object {
        val SENSOR_COLOR = PixelSensor.COLOR.code
        val STREAMS = PixelSensor.COLOR.streams.bits()
    }
}
