package dev.ml2sensors.capture

import dev.ml2sensors.message.MlPose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamTable
import java.nio.ByteBuffer

/** The ml2s_frames of one poll. C writes them into [memory]; they are read here by the offsets that C reports. */
internal class FrameBlock(capacity: Int) {
    val memory: ByteBuffer = structMemory(capacity, FrameLayout.sizeBytes)

    /** Returns a view of frame [index], valid until the next poll. */
    operator fun get(index: Int): NativeFrame = NativeFrame(memory, index * FrameLayout.sizeBytes)

    /**
     * Passes the sample of each of [count] polled frames to [take], and ends every lease, also when something fails.
     */
    fun deliver(count: Int, take: (index: Int, frame: NativeFrame, sample: Sample) -> Unit) {
        var next = 0
        try {
            while (next < count) {
                val index = next
                val sample = this[index].toSample()
                next++ // The lease is the sample's now
                try {
                    take(index, this[index], sample)
                } finally {
                    (sample as? ImageSample)?.release()
                }
            }
        } finally {
            while (next < count) this[next++].release()
        }
    }
}

/** The offsets of the fields of ml2s_frame, in bytes. */
private object FrameLayout {
    private val offsets = Offsets(Native.frameLayout())
    val sizeBytes = offsets.next()
    val stream = offsets.next()
    val slot = offsets.next()
    val has = offsets.next()
    val frameNumber = offsets.next()
    val captureNanos = offsets.next()
    val planes = offsets.next()
    val planeBytes = offsets.next()
    val planeOffset = offsets.next()
    val planeSize = offsets.next()
    val planeStride = offsets.next()
    val width = offsets.next()
    val height = offsets.next()
    val rotation = offsets.next()
    val position = offsets.next()
    val lens = offsets.next()
    val focalLength = offsets.next()
    val principalPoint = offsets.next()
    val distortion = offsets.next()
    val exposureNanos = offsets.next()
    val analogGain = offsets.next()
    val digitalGain = offsets.next()
    val illumination = offsets.next()
    val skipped = offsets.next()
    val headRotation = offsets.next()
    val headPosition = offsets.next()

    init {
        offsets.end()
    }
}

/** The ml2s_frame at [base] of [memory]. */
internal class NativeFrame(private val memory: ByteBuffer, private val base: Int) {
    val stream: Int get() = int(FrameLayout.stream)
    val slot: Int get() = int(FrameLayout.slot)
    val frameNumber: Long get() = long(FrameLayout.frameNumber)
    val captureNanos: Long get() = long(FrameLayout.captureNanos)
    val width: Int get() = int(FrameLayout.width)
    val height: Int get() = int(FrameLayout.height)

    /** The number of unusable frames of the stream that were skipped before this one. */
    val skipped: Int get() = int(FrameLayout.skipped)

    /** True if the device delivered a usable frame, even if no slot was free for it. */
    val isUsable: Boolean get() = width > 0

    /** The pose of the camera at the capture, null if unknown. */
    var pose: MlPose?
        get() = if (has(HAS_POSE)) memory.mlPose(base + FrameLayout.position, base + FrameLayout.rotation) else null
        private set(pose) = set(HAS_POSE, pose) {
            memory.putMlPose(base + FrameLayout.position, base + FrameLayout.rotation, it)
        }

    /** The pose of the head at the capture, null if unknown. */
    var headPose: MlPose?
        get() {
            if (!has(HAS_HEAD_POSE)) return null
            return memory.mlPose(base + FrameLayout.headPosition, base + FrameLayout.headRotation)
        }
        set(pose) = set(HAS_HEAD_POSE, pose) {
            memory.putMlPose(base + FrameLayout.headPosition, base + FrameLayout.headRotation, it)
        }

    var intrinsics: Intrinsics?
        get() {
            if (!has(HAS_INTRINSICS)) return null
            val (fx, fy) = doubles(FrameLayout.focalLength, 2)
            val (cx, cy) = doubles(FrameLayout.principalPoint, 2)
            return Intrinsics(width, height, fx, fy, cx, cy, distortion())
        }
        private set(intrinsics) = set(HAS_INTRINSICS, intrinsics) {
            putDoubles(FrameLayout.focalLength, it.fx, it.fy)
            putDoubles(FrameLayout.principalPoint, it.cx, it.cy)
            putDistortion(it.distortion)
        }

    val metadata: CaptureMetadata
        get() = CaptureMetadata(
            if (has(HAS_EXPOSURE)) long(FrameLayout.exposureNanos) else null,
            if (has(HAS_ANALOG_GAIN)) int(FrameLayout.analogGain).toDouble() else null,
            if (has(HAS_DIGITAL_GAIN)) int(FrameLayout.digitalGain).toDouble() else null,
            if (has(HAS_ILLUMINATION)) ILLUMINATION[int(FrameLayout.illumination)] else null,
        )

    /** Ends the lease of the frame's slot, if there is one. */
    fun release() {
        if (slot != NO_SLOT) SlotPool.release(StreamTable.all[stream], slot)
    }

    /** Returns the image in its slot, which the sample's release gives back, or what was lost instead. */
    fun toSample(): Sample {
        if (!isUsable) return LostSamples(captureNanos, skipped, DropReason.UNUSABLE)
        if (slot == NO_SLOT) return LostSamples(captureNanos, 1, DropReason.NO_BUFFER)
        val slot = slot
        val stream = StreamTable.all[stream]
        return ImageSample(
            captureNanos,
            frameNumber,
            width,
            height,
            strideBytes(IMAGE),
            pose?.toOptical(),
            intrinsics,
            metadata,
            PLANE_ROLES.mapIndexedNotNull { plane, role ->
                rangeOf(plane)?.let { ImageSample.Plane(role, SlotPool.bytes(stream, slot, it)) }
            },
            giveBack = { SlotPool.release(stream, slot) },
        )
    }

    /** Sets the slot of this frame, whose [sizeBytes] begin at the start of [slot]. */
    fun place(stream: Int, slot: Int, sizeBytes: Int) {
        memory.putInt(base + FrameLayout.stream, stream)
        memory.putInt(base + FrameLayout.slot, slot)
        memory.putInt(base + plane(IMAGE) + FrameLayout.planeSize, sizeBytes)
    }

    /** Sets size, time, pose and intrinsics to those of [sample]. */
    fun fill(sample: ImageSample) {
        memory.putLong(base + FrameLayout.frameNumber, sample.frameNumber)
        memory.putLong(base + FrameLayout.captureNanos, sample.captureNanos)
        memory.putInt(base + FrameLayout.width, sample.width)
        memory.putInt(base + FrameLayout.height, sample.height)
        memory.putInt(base + plane(IMAGE) + FrameLayout.planeStride, sample.strideBytes)
        pose = sample.pose?.let(MlPose::ofOptical)
        intrinsics = sample.intrinsics
    }

    /** Sets the time to that of [sample], the latest reading. */
    fun fill(sample: VectorSample) {
        memory.putLong(base + FrameLayout.captureNanos, sample.captureNanos)
    }

    /** Returns the distance between rows of the plane [role], an ml2s_plane_role. */
    fun strideBytes(role: Int): Int = int(plane(role) + FrameLayout.planeStride)

    /** Returns the bytes of the plane [role] in its slot, or null if it is absent. */
    fun rangeOf(role: Int): IntRange? {
        val offset = int(plane(role) + FrameLayout.planeOffset)
        val size = int(plane(role) + FrameLayout.planeSize)
        return if (size == 0) null else offset until offset + size
    }

    private fun plane(role: Int) = FrameLayout.planes + role * FrameLayout.planeBytes

    private fun distortion(): Distortion {
        val d = doubles(FrameLayout.distortion, 6)
        return when (val lens = int(FrameLayout.lens)) {
            LENS_PLUMB_BOB -> Distortion.PlumbBob(d[0], d[1], d[2], d[3], d[4])
            LENS_FISHEYE_TANGENTIAL -> Distortion.FisheyeTangential(d[0], d[1], d[2], d[3], d[4], d[5])
            else -> error("the library names a lens $lens that is not in ml2s_lens")
        }
    }

    private fun putDistortion(distortion: Distortion) {
        val c = distortion.coefficients
        val (lens, values) = when (distortion) {
            is Distortion.PlumbBob -> LENS_PLUMB_BOB to c + 0.0

            is Distortion.FisheyeTangential -> LENS_FISHEYE_TANGENTIAL to c

            // The same model without its tangential terms
            is Distortion.Equidistant -> LENS_FISHEYE_TANGENTIAL to c + listOf(0.0, 0.0)
        }
        memory.putInt(base + FrameLayout.lens, lens)
        putDoubles(FrameLayout.distortion, *values.toDoubleArray())
    }

    /** Writes [value] with [put] and sets [bit] in `has`; a null value clears the bit. */
    private inline fun <T : Any> set(bit: Int, value: T?, put: (T) -> Unit) {
        val others = int(FrameLayout.has) and bit.inv()
        memory.putInt(base + FrameLayout.has, if (value == null) others else others or bit)
        if (value != null) put(value)
    }

    private fun has(bit: Int) = int(FrameLayout.has) and bit != 0

    private fun int(offset: Int) = memory.getInt(base + offset)

    private fun long(offset: Int) = memory.getLong(base + offset)

    private fun doubles(offset: Int, count: Int) =
        DoubleArray(count) { memory.getDouble(base + offset + it * Double.SIZE_BYTES) }

    private fun putDoubles(offset: Int, vararg values: Double) {
        for ((index, value) in values.withIndex()) memory.putDouble(base + offset + index * Double.SIZE_BYTES, value)
    }

    companion object {
        const val NO_SLOT = -1

        /** ML2S_PLANE_IMAGE */
        const val IMAGE = 0

        const val HAS_POSE = 1
        const val HAS_INTRINSICS = 2
        const val HAS_EXPOSURE = 4
        const val HAS_ANALOG_GAIN = 8
        const val HAS_DIGITAL_GAIN = 16
        const val HAS_ILLUMINATION = 32
        const val HAS_HEAD_POSE = 64

        const val LENS_PLUMB_BOB = 0
        const val LENS_FISHEYE_TANGENTIAL = 1

        private val ILLUMINATION = listOf("off", "on")

        /** The stream table's name of each ml2s_plane_role. */
        private val PLANE_ROLES = listOf(ImageSample.IMAGE, "confidence", "flags")
    }
}

/** Reads a pose of three floats at [position] and four at [rotation]. */
internal fun ByteBuffer.mlPose(position: Int, rotation: Int): MlPose {
    fun float(offset: Int, index: Int) = getFloat(offset + index * Float.SIZE_BYTES).toDouble()
    return MlPose(
        Vector3(float(position, 0), float(position, 1), float(position, 2)),
        Quaternion(float(rotation, 0), float(rotation, 1), float(rotation, 2), float(rotation, 3)),
    )
}

private fun ByteBuffer.putMlPose(position: Int, rotation: Int, pose: MlPose) {
    fun put(offset: Int, vararg values: Double) {
        for ((index, value) in values.withIndex()) putFloat(offset + index * Float.SIZE_BYTES, value.toFloat())
    }
    put(position, pose.position.x, pose.position.y, pose.position.z)
    put(rotation, pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w)
}
