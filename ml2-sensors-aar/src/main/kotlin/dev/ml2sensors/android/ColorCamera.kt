package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.hardware.camera2.CameraCharacteristics
import android.hardware.camera2.params.StreamConfigurationMap
import android.util.Range
import android.util.Size

/** The capabilities of camera [id], with [workers] threads that encode. */
internal class ColorCamera(
    val id: String,
    private val characteristics: CameraCharacteristics,
    private val encoderSpeed: EncoderSpeed,
    private val workers: Int,
) {
    private val map: StreamConfigurationMap? = characteristics[CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP]

    /** True if Android documents this camera's timestamps as CLOCK_BOOTTIME. */
    val stampsBootTime: Boolean
        get() = characteristics[CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE] ==
            CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE_REALTIME

    /**
     * Returns how to capture [size] at [rateHz], or null if the camera has no images of that size. The camera's own
     * JPEGs are used only if they delay no other frame and are fast enough.
     */
    fun plan(size: Size, rateHz: Int): CapturePlan? {
        val jpeg = map?.takeIf { size in it.sizes(ImageFormat.JPEG) }?.let { map ->
            val stallNanos = map.getOutputStallDuration(ImageFormat.JPEG, size)
            CapturePlan(ImageFormat.JPEG, size, map.rateHz(ImageFormat.JPEG, size)).takeIf { stallNanos == 0L }
        }
        if (jpeg?.sustains(rateHz) == true) return jpeg
        val yuv = map?.takeIf { size in it.sizes(ImageFormat.YUV_420_888) }?.let { map ->
            val encodedHz = encoderSpeed.rateHz(size.width, size.height, workers)
            CapturePlan(ImageFormat.YUV_420_888, size, minOf(map.rateHz(ImageFormat.YUV_420_888, size), encodedHz))
        }
        return listOfNotNull(jpeg, yuv).maxByOrNull { it.sustainedHz }
    }

    /** Returns how to capture raw images of [size], or null if the camera has none of that size. */
    fun rawPlan(size: Size): CapturePlan? = map?.takeIf { size in it.sizes(ImageFormat.YUV_420_888) }?.let {
        CapturePlan(ImageFormat.YUV_420_888, size, it.rateHz(ImageFormat.YUV_420_888, size), isRaw = true)
    }

    /** Returns the error message for a [size] that has no plan. */
    fun lacks(size: Size): String {
        val sizes = map?.sizes(ImageFormat.YUV_420_888).orEmpty()
        return "camera $id has no images of $size; it has: ${sizes.joinToString()}"
    }

    /** Returns the frame rate range for automatic exposure: the narrowest one that ends at [rateHz]. */
    fun fpsRange(rateHz: Int): Range<Int> =
        fpsRanges.filter { it.upper == rateHz }.maxByOrNull { it.lower } ?: Range(rateHz, rateHz)

    /** Returns true if automatic exposure offers [rateHz], or if the camera lists no rates at all. */
    fun offers(rateHz: Int): Boolean = fpsRanges.isEmpty() || fpsRanges.any { it.upper == rateHz }

    private val fpsRanges: List<Range<Int>>
        get() = characteristics[CameraCharacteristics.CONTROL_AE_AVAILABLE_TARGET_FPS_RANGES].orEmpty().toList()

    private fun StreamConfigurationMap.sizes(format: Int) = getOutputSizes(format).orEmpty().toList()

    /** Returns the highest rate, or infinity if the camera does not list one. */
    private fun StreamConfigurationMap.rateHz(format: Int, size: Size) = 1e9 / getOutputMinFrameDuration(format, size)
}
