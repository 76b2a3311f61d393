package dev.ml2sensors.source

import dev.ml2sensors.message.Transform
import java.nio.ByteBuffer
import java.util.concurrent.atomic.AtomicInteger

/**
 * One capture of a camera, in borrowed memory.
 *
 * The sample is valid until the collector that received it returns. Whoever needs it longer calls [retain] and later
 * [release], exactly once each, from any thread; the memory goes back to its pool with the last release.
 *
 * @property frameNumber the device's number of this capture; gaps are frames the device dropped.
 * @property width in pixels.
 * @property height in pixels.
 * @property strideBytes from one row to the next; 0 for JPEG.
 * @property pose of the optical frame (z forward, x right, y down) in the world frame, null when not known.
 * @property intrinsics as the device gives them for this capture, null where it gives none.
 * @property settings as the device gives them for this capture.
 * @param giveBack ends the loan of all [planes]; called once, by the thread of the last [release].
 */
public class ImageSample(
    override val captureNanos: Long,
    public val frameNumber: Long,
    public val width: Int,
    public val height: Int,
    public val strideBytes: Int,
    public val pose: Transform?,
    public val intrinsics: Intrinsics?,
    public val settings: CaptureSettings,
    private val planes: List<Plane>,
    private val giveBack: () -> Unit,
) : Sample {
    private val references = AtomicInteger(1)

    /** The pixels (rows of [strideBytes], or one JPEG) from position to limit; numbers are little endian. */
    public val pixels: ByteBuffer get() = checkNotNull(plane(IMAGE)) { "sample without an image" }

    /** The pixels of a topic role of the stream table (`image`, `confidence`, `flags`), null when not captured. */
    public fun plane(role: String): ByteBuffer? {
        check(references.get() > 0) { "image sample $frameNumber used after its release" }
        return planes.firstOrNull { it.role == role }?.pixels?.let { it.duplicate().order(it.order()) }
    }

    /** Keeps the memory beyond the collector; each call wants one [release]. */
    public fun retain() {
        val before = references.getAndUpdate { if (it > 0) it + 1 else it }
        check(before > 0) { "image sample $frameNumber retained after its release" }
    }

    /** Ends one use; the last one gives the memory back. */
    public fun release() {
        val left = references.decrementAndGet()
        check(left >= 0) { "image sample $frameNumber released once too often" }
        if (left == 0) giveBack()
    }

    /** The pixels in memory of the caller's own. */
    public fun copy(): ByteArray = pixels.let { source -> ByteArray(source.remaining()).also(source::get) }

    /** Borrowed memory: the [pixels] of one topic [role], from position to limit. */
    public class Plane(public val role: String, public val pixels: ByteBuffer)

    public companion object {
        /** The role of the pixels that every camera has. */
        public const val IMAGE: String = "image"
    }
}

/**
 * How a capture was taken; null where the backend does not say.
 *
 * @property exposureNanos how long light was collected.
 * @property analogGain factor before digitisation.
 * @property digitalGain factor after it.
 * @property illumination the depth camera's own light: `on` or `off`.
 * @property stampSource what the capture time comes from, [EXPOSURE_CENTRE] or [SENSOR_TIMESTAMP].
 */
public data class CaptureSettings(
    val exposureNanos: Long? = null,
    val analogGain: Double? = null,
    val digitalGain: Double? = null,
    val illumination: String? = null,
    val stampSource: String? = null,
) {
    public companion object {
        /** The device's own time of the centre of exposure. */
        public const val EXPOSURE_CENTRE: String = "exposure_centre"

        /** Camera2's start of exposure and half the exposure time. */
        public const val SENSOR_TIMESTAMP: String = "sensor_timestamp"
    }
}
