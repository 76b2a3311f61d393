package dev.ml2sensors.android

import android.hardware.camera2.CaptureRequest
import android.hardware.camera2.CaptureResult
import android.util.Log
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics

/**
 * Reads the vendor's tags in capture results. The vendor's ml_camera_vendor_tags.h defines their names and layouts.
 *
 * @param prefix begins their names: `com.amd.control` for cameras 0 and 1, `com.ml.control` for camera 3.
 */
internal class VendorTags(prefix: String) {
    private val timestamps = VendorTag("$prefix.cvip_timestamps", LongArray::class.java)
    private val intrinsics = VendorTag("$prefix.intrinsics", FloatArray::class.java)

    /** Returns the MLTime of the centre of exposure, or null if the camera does not report it; 0 means unknown. */
    fun exposureCentreNanos(result: CaptureResult): Long? {
        val nanos = timestamps.of(result)?.getOrNull(CENTRE)?.takeIf { it != 0L } ?: return null
        return if (nanos > 0) nanos else timestamps.refuse("a time after 0", "$nanos")
    }

    /**
     * Returns the intrinsics for images of [width] x [height], or null if the camera reports none of that aspect ratio.
     * Rows that are all 0 are unused. A row with a number that no lens has is refused, and the log names it once.
     */
    fun intrinsics(result: CaptureResult, width: Int, height: Int): Intrinsics? {
        val reported = intrinsics.of(result)?.asList()?.chunked(FLOATS_PER_SIZE)?.filter { it.size == FLOATS_PER_SIZE }
        val rows = reported.orEmpty().filter { row -> row.any { it != 0f } }
        val all = rows.mapNotNull { row ->
            if (isLens(row)) row.toIntrinsics() else intrinsics.refuse("a lens' numbers", "$row")
        }
        return all.firstOrNull { it.width == width && it.height == height }
            ?: all.firstOrNull { it.width * height == it.height * width }?.scaledTo(width, height)
    }

    /** Returns true if size, focal lengths and principal point belong to one image, and all numbers are finite. */
    private fun isLens(row: List<Float>): Boolean {
        val (width, height, fx, fy, cx) = row
        val cy = row[5]
        val isSize = listOf(width, height).all { it in 1f..MOST_PIXELS && it % 1 == 0f }
        val isFocal = fx in SHORTEST * width..LONGEST * width && fy in SHORTEST * height..LONGEST * height
        return row.all { it.isFinite() } && isSize && isFocal && cx in 0f..width && cy in 0f..height &&
            row.drop(7).all { it in -MOST_DISTORTION..MOST_DISTORTION }
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
        const val MOST_PIXELS = 65_535f

        /** Focal lengths in widths or heights of the image: from those of a fisheye to those of a telephoto lens. */
        const val SHORTEST = 0.01f
        const val LONGEST = 100f
        const val MOST_DISTORTION = 1e4f
    }
}

/** A capture result tag that some cameras do not have. */
private class VendorTag<T : Any>(private val name: String, private val type: Class<T>) {
    private val key = CaptureResult.Key(name, type)
    private var isKnown = true
    private var isRefused = false

    /** Returns null, and logs once that the tag has [found], where [expected] should be. */
    fun refuse(expected: String, found: String): Nothing? {
        if (!isRefused) Log.w("ml2s", "$name: expected $expected, found $found; images go without")
        isRefused = true
        return null
    }

    /** Returns null if there is no such tag, or if it is of another type than the vendor documents. */
    fun of(result: CaptureResult): T? {
        if (!isKnown) return null
        val value: Any? = try {
            result.get(key)
        } catch (_: IllegalArgumentException) {
            // Camera2's way to say that there is no tag of this name
            isKnown = false
            null
        } catch (e: RuntimeException) {
            // Its way to say that the tag has another type
            refuse(type.simpleName, e.message.orEmpty())
        }
        if (value == null || type.isInstance(value)) return type.cast(value)
        return refuse(type.simpleName, value.javaClass.simpleName)
    }
}

/** A setting of the vendor in the requests to a camera, beside Android's. Source: as of [VendorTags]. */
internal class VendorRequest private constructor(private val name: String, private val value: Byte) {
    /** Sets it in [request]. A device that does not know the tag has its own default, which the log says. */
    fun setIn(request: CaptureRequest.Builder) {
        try {
            request.set(CaptureRequest.Key(name, Byte::class.java), value)
        } catch (e: RuntimeException) { // Camera2's way to say that there is no tag of this name and type
            Log.w("ml2s", "$name: this device does not know the tag, and decides itself: ${e.message}")
        }
    }

    companion object {
        private const val MIXED_REALITY: Byte = 0
        private const val ON: Byte = 1

        /** Camera 0, which any app may use, decides for camera 1 unless that insists. Camera 3 has several pictures. */
        private val ALL = mapOf(
            "1" to VendorRequest("com.amd.control.forceapply", ON),
            "3" to VendorRequest("com.ml.control.capture_mode", MIXED_REALITY),
        )

        /** Returns what a request to the camera [id] says, or null if it says nothing more. */
        fun of(id: String): VendorRequest? = ALL[id]
    }
}
