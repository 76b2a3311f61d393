package dev.ml2sensors.source

import dev.ml2sensors.message.Transform

/** The poses of the colour camera by the vendor's library; its images come from another interface, such as Camera2. */
internal fun interface ColorPoses {
    /** Starts tracking the camera for the calling thread only; returns null if the device has no such library. */
    fun open(): Tracker?

    /** A connection to the vendor's library that only its thread uses and closes. */
    interface Tracker : AutoCloseable {
        /** Converts [deviceNanos] of the vendor's clock (MLTime) to the device timebase, [DeviceClock]. */
        fun captureNanos(deviceNanos: Long): Long

        /**
         * Returns the pose of the camera's optical frame in the world frame at [deviceNanos]. Null if it was not
         * tracked, or if the time is too long ago: the device keeps few poses.
         */
        fun poseAt(deviceNanos: Long): Transform?
    }
}
