package dev.ml2sensors.capture

import dev.ml2sensors.message.MlPose
import java.nio.ByteBuffer

/** The ml2s_poses of one poll. C writes them into [memory]; they are read here by the offsets that C reports. */
internal class PoseBlock(capacity: Int) {
    val memory: ByteBuffer = structMemory(capacity, PoseLayout.sizeBytes)

    /** Returns a view of pose [index], valid until the next poll. */
    operator fun get(index: Int): TrackedPose = TrackedPose(memory, index * PoseLayout.sizeBytes)
}

/** The offsets of the fields of ml2s_pose, in bytes. */
private object PoseLayout {
    private val offsets = Offsets(Native.poseLayout())
    val sizeBytes = offsets.next()
    val stream = offsets.next()
    val captureNanos = offsets.next()
    val rotation = offsets.next()
    val position = offsets.next()
    val isTracked = offsets.next()
    val events = offsets.next()

    init {
        offsets.end()
    }
}

/** The ml2s_pose at [base] of [memory]. */
internal class TrackedPose(private val memory: ByteBuffer, private val base: Int) {
    val stream: Int get() = memory.getInt(base + PoseLayout.stream)
    val captureNanos: Long get() = memory.getLong(base + PoseLayout.captureNanos)

    /** The pose, null while it is not tracked. */
    val pose: MlPose?
        get() = if (memory.getInt(base + PoseLayout.isTracked) == 0) {
            null
        } else {
            memory.mlPose(base + PoseLayout.position, base + PoseLayout.rotation)
        }

    /** True if the world has a new origin, so that earlier poses no longer apply. */
    val isInNewWorld: Boolean
        get() = memory.getInt(base + PoseLayout.events) and (TRACKING_RECOVERY_FAILED or TRACKING_NEW_SESSION) != 0

    companion object {
        const val TRACKING_RECOVERY_FAILED = 4
        const val TRACKING_NEW_SESSION = 8
    }
}
