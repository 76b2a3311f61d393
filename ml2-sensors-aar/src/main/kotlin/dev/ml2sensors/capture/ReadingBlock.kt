package dev.ml2sensors.capture

import dev.ml2sensors.message.MlPose
import java.nio.ByteBuffer

/** The ml2s_readings of one poll. C writes them into [memory]; they are read here by the offsets that C reports. */
internal class ReadingBlock(capacity: Int) {
    val memory: ByteBuffer = structMemory(capacity, ReadingLayout.sizeBytes)

    /** Returns a view of reading [index], valid until the next poll. */
    operator fun get(index: Int): Reading = Reading(memory, index * ReadingLayout.sizeBytes)
}

/** The offsets of the fields of ml2s_reading, in bytes. */
private object ReadingLayout {
    private val offsets = Offsets(Native.readingLayout())
    val sizeBytes = offsets.next()
    val stream = offsets.next()
    val captureNanos = offsets.next()
    val rotation = offsets.next()
    val position = offsets.next()
    val isTracked = offsets.next()
    val events = offsets.next()
    val values = offsets.next()
    val id = offsets.next()
    val name = offsets.next()

    init {
        offsets.end()
    }
}

/** The ml2s_reading at [base] of [memory]. */
internal class Reading(private val memory: ByteBuffer, private val base: Int) {
    val stream: Int get() = memory.getInt(base + ReadingLayout.stream)
    val captureNanos: Long get() = memory.getLong(base + ReadingLayout.captureNanos)

    /** False while the thing is not seen or not connected. */
    val isTracked: Boolean get() = memory.getInt(base + ReadingLayout.isTracked) != 0

    /** The pose, null while it is not tracked. */
    val pose: MlPose?
        get() =
            if (isTracked) memory.mlPose(base + ReadingLayout.position, base + ReadingLayout.rotation) else null

    /** True if the world has a new origin, so that earlier poses no longer apply. */
    val isInNewWorld: Boolean
        get() = memory.getInt(base + ReadingLayout.events) and (TRACKING_RECOVERY_FAILED or TRACKING_NEW_SESSION) != 0

    /** The number of a joint or marker. */
    val id: Long get() = memory.getLong(base + ReadingLayout.id)

    /** The content of a QR code, or the UUID and name of a map. */
    val name: String
        get() {
            val end = generateSequence(base + ReadingLayout.name) { it + 1 }.first { memory[it].toInt() == 0 }
            val bytes = ByteArray(end - base - ReadingLayout.name) { memory[base + ReadingLayout.name + it] }
            return bytes.decodeToString()
        }

    /** Returns the value [index] of ml2s_input, ml2s_marker_value, ml2s_map_value, ml2s_head_value or ml2s_gaze_value. */
    fun value(index: Int): Float = memory.getFloat(base + ReadingLayout.values + index * Float.SIZE_BYTES)

    companion object {
        const val TRACKING_RECOVERY_FAILED = 4
        const val TRACKING_NEW_SESSION = 8
        const val INPUT_TRIGGER = 0
        const val INPUT_BUMPER = 1
        const val INPUT_MENU = 2
        const val INPUT_TOUCHED = 3
        const val INPUT_TOUCH_X = 4
        const val INPUT_TOUCH_Y = 5
        const val INPUT_FORCE = 6
        const val MARKER_LENGTH_M = 0
        const val MARKER_REPROJECTION_ERROR_M = 1
        const val MAP_STATE = 0
        const val MAP_CONFIDENCE = 1
        const val MAP_ERRORS = 2
        const val MAP_TYPE = 3
        const val HEAD_STATUS = 0
        const val HEAD_CONFIDENCE = 1
        const val HEAD_ERRORS = 2
        const val GAZE_FIT = 0
        const val GAZE_CALIBRATION = 1
    }
}
