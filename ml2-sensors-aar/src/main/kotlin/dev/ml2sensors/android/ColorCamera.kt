package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.hardware.camera2.CameraCharacteristics
import android.hardware.camera2.params.StreamConfigurationMap
import android.util.Range
import android.util.Size

/** Camera [id] and what it can do, with [workers] threads that encode. */
internal class ColorCamera(
    val id: String,
    private val characteristics: CameraCharacteristics,
    private val encoderSpeed: EncoderSpeed,
    private val workers: Int,
) {
    private val map: StreamConfigurationMap? = characteristics[CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP]

    /** Whether Android promises timestamps of CLOCK_BOOTTIME. */
    val stampsBootTime: Boolean
        get() = characteristics[CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE] ==
            CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE_REALTIME

    /** The camera's own JPEGs only where they hold up no other frame, and only if they are as fast as asked for. */
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

    /** Why there is no plan for [size]. */
    fun lacks(size: Size): String {
        val sizes = map?.sizes(ImageFormat.YUV_420_888).orEmpty()
        return "camera $id has no images of $size; it has: ${sizes.joinToString()}"
    }

    /** What to ask automatic exposure for: the steadiest range with [rateHz] at its top. */
    fun fpsRange(rateHz: Int): Range<Int> =
        fpsRanges.filter { it.upper == rateHz }.maxByOrNull { it.lower } ?: Range(rateHz, rateHz)

    /** Whether automatic exposure has this rate; a camera that lists none is believed to. */
    fun offers(rateHz: Int): Boolean = fpsRanges.isEmpty() || fpsRanges.any { it.upper == rateHz }

    private val fpsRanges: List<Range<Int>>
        get() = characteristics[CameraCharacteristics.CONTROL_AE_AVAILABLE_TARGET_FPS_RANGES].orEmpty().toList()

    private fun StreamConfigurationMap.sizes(format: Int) = getOutputSizes(format).orEmpty().toList()

    /** Infinite where the camera does not say. */
    private fun StreamConfigurationMap.rateHz(format: Int, size: Size) = 1e9 / getOutputMinFrameDuration(format, size)
}
