package dev.ml2sensors.android

import android.hardware.camera2.CameraCaptureSession
import android.hardware.camera2.CaptureRequest
import android.hardware.camera2.CaptureResult
import android.hardware.camera2.TotalCaptureResult
import android.media.ImageReader
import dev.ml2sensors.source.DropReason

/**
 * Makes samples of what a running camera calls back with. Used by the camera's thread only.
 *
 * @param deliver takes an image on its way to become a sample, in order of capture.
 * @param lost is told of images that will not be delivered.
 * @param fail is told why nothing more can be delivered.
 */
internal class CaptureCallbacks(
    private val intake: ImageCopier,
    private val exposures: ExposureReader,
    private val deliver: (image: CopiedImage, exposure: Exposure, captureNanos: Long) -> Unit,
    private val lost: (DropReason) -> Unit,
    private val fail: (Exception) -> Unit,
) : CameraCaptureSession.CaptureCallback(),
    ImageReader.OnImageAvailableListener {
    private val pairing = TimestampPairing<CopiedImage, Exposure>(::pair, ::giveUp)

    override fun onImageAvailable(reader: ImageReader) = guarded {
        reader.acquireNextImage()?.use { image ->
            intake.take(image)?.let { pairing.image(image.timestamp, it) }
        }
    }

    override fun onCaptureCompleted(
        session: CameraCaptureSession,
        request: CaptureRequest,
        result: TotalCaptureResult,
    ) = guarded {
        result.get(CaptureResult.SENSOR_TIMESTAMP)?.let { pairing.result(it, exposures.read(result, it)) }
    }

    private fun pair(image: CopiedImage, exposure: Exposure) {
        val captureNanos = exposure.captureNanos ?: return giveUp(image)
        deliver(image, exposure, captureNanos)
    }

    private fun giveUp(image: CopiedImage) {
        image.giveUp()
        lost(DropReason.SOURCE_LATE)
    }

    /** What is thrown here would end the app. */
    private inline fun guarded(callback: () -> Unit) {
        try {
            callback()
        } catch (e: Exception) {
            fail(e)
        }
    }
}
