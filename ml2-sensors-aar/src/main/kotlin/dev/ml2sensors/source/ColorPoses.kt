package dev.ml2sensors.source

import dev.ml2sensors.message.Transform

/** What the vendor's library adds to the images of the colour camera, which come from elsewhere. */
public fun interface ColorPoses {
    /**
     * Begins to track the camera. The result is used and closed by the calling thread only.
     *
     * @throws SourceException where the device has no such library.
     */
    public fun open(): Tracker

    public interface Tracker : AutoCloseable {
        /** The instant [deviceNanos] of the vendor's clock, MLTime, on the device timebase. */
        public fun captureNanos(deviceNanos: Long): Long

        /**
         * The pose of the camera's optical frame in the world frame at [deviceNanos], null when it was not tracked or
         * is no longer remembered: to be asked for as soon as a capture is known.
         */
        public fun poseAt(deviceNanos: Long): Transform?
    }
}
