package dev.ml2sensors.source

import dev.ml2sensors.message.Transform
import java.nio.ByteBuffer
import java.util.concurrent.atomic.AtomicInteger

/**
 * One capture of a camera, in memory of a pool.
 *
 * The sample is valid until the collector that received it returns. To use it longer, call [retain] and later
 * [release], exactly once each, from any thread; the last release returns the memory to its pool.
 *
 * @property frameNumber the device's number of this capture; gaps are frames that the device dropped.
 * @property width in pixels.
 * @property height in pixels.
 * @property strideBytes the distance between rows; 0 for a compressed image.
 * @property pose of the optical frame (z forward, x right, y down) in the world frame, null if unknown.
 * @property intrinsics as the device reports them for this capture, null if it does not.
 * @property metadata as the device reports it for this capture.
 * @param giveBack releases the memory of all [planes]; called once, by the thread of the last [release].
 */
public class ImageSample(
    override val captureNanos: Long,
    public val frameNumber: Long,
    public val width: Int,
    public val height: Int,
    public val strideBytes: Int,
    public val pose: Transform?,
    public val intrinsics: Intrinsics?,
    public val metadata: CaptureMetadata,
    private val planes: List<Plane>,
    private val giveBack: () -> Unit,
) : Sample {
    private val references = AtomicInteger(1)

    /** The pixels, rows of [strideBytes] or one compressed image, from position to limit; numbers are little endian. */
    public val pixels: ByteBuffer get() = checkNotNull(plane(IMAGE)) { "sample without an image" }

    /**
     * Returns the plane of a topic role of the stream table (`image`, `confidence`, `flags`), or null if it was not
     * captured.
     */
    public fun plane(role: String): ByteBuffer? {
        check(references.get() > 0) { "image sample $frameNumber used after its release" }
        return planes.firstOrNull { it.role == role }?.pixels?.let { it.duplicate().order(it.order()) }
    }

    /** Adds a reference, so that the memory stays valid after the collector returns; each call needs one [release]. */
    public fun retain() {
        val before = references.getAndUpdate { if (it > 0) it + 1 else it }
        check(before > 0) { "image sample $frameNumber retained after its release" }
    }

    /** Removes a reference; the last one returns the memory to its pool. */
    public fun release() {
        val left = references.decrementAndGet()
        check(left >= 0) { "image sample $frameNumber released once too often" }
        if (left == 0) giveBack()
    }

    /** The planes other than the image; valid as long as the sample. */
    internal val planesBesideImage: List<Plane> get() = planes.filter { it.role != IMAGE }

    /** Returns a copy of the pixels. */
    public fun copy(): ByteArray = pixels.let { source -> ByteArray(source.remaining()).also(source::get) }

    /** The [pixels] of one topic [role], from position to limit. */
    public class Plane(public val role: String, public val pixels: ByteBuffer)

    public companion object {
        /** The role of the plane that every camera has. */
        public const val IMAGE: String = "image"

        /**
         * The role of the plane with the colours of a raw colour image, whose [IMAGE] is its brightness: pairs of V and U
         * for each 2 x 2 pixels (NV21, full range, BT.601), in rows without padding.
         */
        public const val CHROMA: String = "chroma"
    }
}

/**
 * Metadata of a capture; null if the backend does not report it.
 *
 * @property exposureNanos exposure time.
 * @property analogGain gain before digitisation.
 * @property digitalGain gain after digitisation.
 * @property illumination the depth camera's own light: `on` or `off`.
 * @property stampSource the origin of the capture time, [EXPOSURE_CENTRE] or [SENSOR_TIMESTAMP].
 */
public data class CaptureMetadata(
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
