package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.util.Size

/**
 * The settings of one camera run.
 *
 * @property format [ImageFormat.JPEG], or [ImageFormat.YUV_420_888] if this library encodes.
 * @property isRaw true if the images stay as they are, for video.
 * @property sustainedHz the highest rate that camera and encoder sustain.
 */
internal class CapturePlan(
    val format: Int,
    val size: Size,
    val sustainedHz: Double,
    val isRaw: Boolean = false,
) {
    /** Returns true if [rateHz] can be sustained; Android rounds durations to whole nanoseconds. */
    fun sustains(rateHz: Int): Boolean = sustainedHz > rateHz - 0.01
}
