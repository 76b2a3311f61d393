package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.util.Size

/**
 * How a camera is to be run.
 *
 * @property format [ImageFormat.JPEG], or [ImageFormat.YUV_420_888] to be encoded here.
 * @property sustainedHz what camera and encoder can do in this way.
 */
internal class CapturePlan(val format: Int, val size: Size, val sustainedHz: Double) {
    /** Durations are told in whole nanoseconds. */
    fun sustains(rateHz: Int): Boolean = sustainedHz > rateHz - 0.01
}
