package dev.ml2sensors.pacing

import dev.ml2sensors.table.StreamTable

/** The rate of a stream's images in captures per second, and their JPEG quality, null if they have none. */
internal data class ImageSetting(val rateHz: Int, val quality: Int?) {
    /** Returns this setting with nothing above a step's value. */
    fun atMost(step: AdaptationStep): ImageSetting =
        ImageSetting(minOf(rateHz, step.rateHz ?: rateHz), quality?.let { minOf(it, step.quality ?: it) })

    /** Returns true if neither value is above that of [other]. */
    fun isWithin(other: ImageSetting): Boolean =
        rateHz <= other.rateHz && (quality ?: 0) <= (other.quality ?: Int.MAX_VALUE)
}

/**
 * A stream whose images give way to the link. Its pipeline calls [admits] and [published], from one thread at a time;
 * [present] may be changed and [bytesPerSecond] called from another.
 *
 * @property configured the upper bound of [present].
 */
internal class AdaptedStream(val id: String, val configured: ImageSetting) {
    @Volatile
    var present: ImageSetting = configured

    /** The size of an image with the configured quality, in bytes; 0 before the first. */
    @Volatile
    private var imageBytes = 0.0
    private var nextNanos = 0L

    /** Returns true if the capture at [captureNanos] is published at the present rate. */
    fun admits(captureNanos: Long): Boolean {
        val rateHz = present.rateHz
        if (rateHz >= configured.rateHz) return true
        val periodNanos = NANOS_PER_SECOND / rateHz
        // Captures do not come at exact times: half of their own period decides
        val early = nextNanos - captureNanos - NANOS_PER_SECOND / configured.rateHz / 2
        if (early in 1..periodNanos) return false
        // A rate that was just changed, and a gap between captures, begin anew
        val isRegular = nextNanos - captureNanos in -periodNanos..periodNanos
        nextNanos = (if (isRegular) nextNanos else captureNanos) + periodNanos
        return true
    }

    /** An image of [bytes] was published with [setting]. */
    fun published(bytes: Int, setting: ImageSetting) {
        val configuredBytes = bytes / size(setting)
        imageBytes = if (imageBytes == 0.0) configuredBytes else imageBytes + SMOOTHING * (configuredBytes - imageBytes)
    }

    /** Returns what the images would need with [setting], in B/s; 0 before the first image. */
    fun bytesPerSecond(setting: ImageSetting): Double = imageBytes * size(setting) * setting.rateHz

    /** The size of an image with [setting], relative to the configured one. */
    private fun size(setting: ImageSetting): Double {
        val quality = setting.quality ?: return 1.0
        return jpegSize(quality) / jpegSize(checkNotNull(configured.quality))
    }

    private companion object {
        const val NANOS_PER_SECOND = 1_000_000_000L
        const val SMOOTHING = 0.125

        /** Returns the size of a JPEG by the stream table, relative to that at quality 80. */
        fun jpegSize(quality: Int): Double {
            val sizes = StreamTable.jpegSizes
            val above = sizes.keys.first { it >= quality }
            val below = sizes.keys.last { it <= quality }
            if (above == below) return sizes.getValue(quality)
            val part = (quality - below).toDouble() / (above - below)
            return sizes.getValue(below) + part * (sizes.getValue(above) - sizes.getValue(below))
        }
    }
}
