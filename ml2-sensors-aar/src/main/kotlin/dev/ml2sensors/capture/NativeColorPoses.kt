package dev.ml2sensors.capture

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.ColorPoses

/**
 * Tracks the colour camera with the vendor's SDK. [open] fails with [CaptureException], and returns null on a device
 * without the SDK.
 */
internal object NativeColorPoses : ColorPoses {
    override fun open(): ColorPoses.Tracker? =
        try {
            NativeColorTracker()
        } catch (_: CaptureException.NotAvailable) {
            null
        }
}

private class NativeColorTracker : ColorPoses.Tracker {
    private val poses = ReadingBlock(1)
    private val handle =
        NativeSettings(PixelSensor.COLOR.code, NativeBackend.SDK.code, PixelSensor.COLOR.streams.bits()).open()

    override fun captureNanos(deviceNanos: Long): Long = Native.boottimeOf(deviceNanos)

    override fun poseAt(deviceNanos: Long): Transform? =
        if (Native.colorPose(handle, deviceNanos, poses.memory)) poses[0].pose?.toOptical() else null

    override fun close(): Unit = Native.close(handle)
}
