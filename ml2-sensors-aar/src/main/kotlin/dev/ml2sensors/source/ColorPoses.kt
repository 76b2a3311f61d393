package dev.ml2sensors.source

import dev.ml2sensors.message.Transform

/** What the vendor's library knows of the colour camera, whose images come by another way, such as Camera2. */
public fun interface ColorPoses {
    /** Begins to track the camera, for the calling thread only; null where the device has no such library. */
    public fun open(): Tracker?

    /** One thread's connection to the vendor's library; only that thread uses and closes it. */
    public interface Tracker : AutoCloseable {
        /** The instant [deviceNanos] of the vendor's clock (MLTime) on the device timebase, [DeviceClock]. */
        public fun captureNanos(deviceNanos: Long): Long

        /**
         * The pose of the camera's optical frame in the world frame at [deviceNanos]; null when it was not tracked, or
         * when it is asked for too late: the device remembers little.
         */
        public fun poseAt(deviceNanos: Long): Transform?
    }
}
