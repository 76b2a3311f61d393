package dev.ml2sensors.android

import android.hardware.camera2.CaptureResult
import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.Intrinsics

/**
 * The capture result of one image.
 *
 * @property captureNanos the capture time on the device timebase, null if the clock is not known yet.
 * @property stampSource the origin of [captureNanos], as [CaptureMetadata.stampSource].
 */
internal class Exposure(
    val frameNumber: Long,
    val captureNanos: Long?,
    val stampSource: String,
    val exposureNanos: Long?,
    val pose: Transform?,
    val intrinsics: Intrinsics?,
)

/**
 * Reads capture results as soon as they arrive. With the vendor's tags the capture time is the centre of exposure, and
 * the pose is the camera's at that time. Without them, or if the vendor's library fails, the time is Camera2's start of
 * exposure plus half the exposure time. If the pose is not available, the image is delivered without one.
 *
 * @param toCaptureNanos converts Camera2's timestamps to the device timebase.
 */
internal class ExposureReader(
    private val width: Int,
    private val height: Int,
    private val tags: VendorTags,
    private val tracker: CameraTracker,
    private val toCaptureNanos: (timestamp: Long) -> Long?,
) {
    fun read(result: CaptureResult, timestamp: Long): Exposure {
        val mlTimeNanos = tags.exposureCentreNanos(result)
        val exposureNanos = result.get(CaptureResult.SENSOR_EXPOSURE_TIME)?.takeIf { it in 1..LONGEST_NANOS }
        val centreNanos = mlTimeNanos?.let { tracker.ask { poses -> poses.captureNanos(it) } }
        return Exposure(
            result.frameNumber,
            centreNanos ?: toCaptureNanos(timestamp)?.plus((exposureNanos ?: 0) / 2),
            if (centreNanos == null) CaptureMetadata.SENSOR_TIMESTAMP else CaptureMetadata.EXPOSURE_CENTRE,
            exposureNanos,
            centreNanos?.let { tracker.ask { poses -> poses.poseAt(mlTimeNanos) } },
            tags.intrinsics(result, width, height),
        )
    }

    private companion object {
        /** Far longer than any camera of the headset exposes. */
        const val LONGEST_NANOS = 1_000_000_000L
    }
}
