package dev.ml2sensors.android

import dev.ml2sensors.capture.CaptureException
import dev.ml2sensors.capture.ColorCameraPoses
import dev.ml2sensors.capture.NativeHeadsetClock
import dev.ml2sensors.message.Transform

/** What the vendor's library knows of the colour camera, whose images come from Camera2. */
internal fun interface ColorPoses {
    /** Begins to track the camera, for the calling thread only; null where the device has no such library. */
    fun open(): Tracker?

    interface Tracker : AutoCloseable {
        /** The instant [mlTimeNanos] of the vendor's clock on the device timebase. */
        fun captureNanos(mlTimeNanos: Long): Long

        /**
         * The pose of the camera's optical frame in the world frame at [mlTimeNanos]; null when it was not tracked, or
         * when it is asked for too late: the device remembers little.
         */
        fun poseAt(mlTimeNanos: Long): Transform?
    }
}

/** Of libml2sensors.so. */
internal object NativeColorPoses : ColorPoses {
    override fun open(): ColorPoses.Tracker? =
        try {
            NativeTracker(ColorCameraPoses())
        } catch (_: CaptureException.NotAvailable) {
            null
        }

    private class NativeTracker(private val poses: ColorCameraPoses) : ColorPoses.Tracker {
        override fun captureNanos(mlTimeNanos: Long): Long = NativeHeadsetClock.ofMlTime(mlTimeNanos)

        override fun poseAt(mlTimeNanos: Long): Transform? = poses.at(mlTimeNanos)

        override fun close(): Unit = poses.close()
    }
}
