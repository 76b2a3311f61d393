package dev.ml2sensors.android

import android.hardware.camera2.CaptureResult
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics

/**
 * The vendor's tags in capture results. Source of names and layouts: the vendor's ml_camera_vendor_tags.h.
 *
 * @param prefix `com.amd.control` for cameras 0 and 1, `com.ml.control` for camera 3.
 */
internal class VendorTags(prefix: String) {
    private val timestamps = VendorTag("$prefix.cvip_timestamps", LongArray::class.java)
    private val intrinsics = VendorTag("$prefix.intrinsics", FloatArray::class.java)

    /** Returns the MLTime of the centre of exposure, or null if the camera does not report it; 0 means unknown. */
    fun exposureCentreNanos(result: CaptureResult): Long? =
        timestamps.of(result)?.getOrNull(CENTRE)?.takeIf { it != 0L }

    /**
     * Returns the intrinsics for images of [width] x [height], or null if the camera reports none of that aspect ratio.
     */
    fun intrinsics(result: CaptureResult, width: Int, height: Int): Intrinsics? {
        val reported = intrinsics.of(result)?.asList()?.chunked(FLOATS_PER_SIZE)?.filter { it.size == FLOATS_PER_SIZE }
        val all = reported.orEmpty().map { it.toIntrinsics() }
        return all.firstOrNull { it.width == width && it.height == height }
            ?: all.firstOrNull { it.width * height == it.height * width }?.scaledTo(width, height)
    }

    private fun List<Float>.toIntrinsics(): Intrinsics {
        val numbers = map(Float::toDouble)
        // The seventh is the field of view
        val (k1, k2, p1, p2, k3) = numbers.drop(7)
        return Intrinsics(
            width = this[0].toInt(),
            height = this[1].toInt(),
            fx = numbers[2],
            fy = numbers[3],
            cx = numbers[4],
            cy = numbers[5],
            Distortion.PlumbBob(k1, k2, p1, p2, k3),
        )
    }

    private companion object {
        const val CENTRE = 1
        const val FLOATS_PER_SIZE = 12
    }
}

/** A capture result tag that some cameras do not have. */
private class VendorTag<T>(name: String, type: Class<T>) {
    private val key = CaptureResult.Key(name, type)
    private var isKnown = true

    fun of(result: CaptureResult): T? {
        if (!isKnown) return null
        return try {
            result.get(key)
        } catch (_: IllegalArgumentException) {
            // Camera2's way to say that there is no tag of this name
            isKnown = false
            null
        }
    }
}
