package dev.ml2sensors.android

import android.hardware.camera2.CameraCaptureSession
import android.hardware.camera2.CaptureFailure
import android.hardware.camera2.CaptureRequest
import android.hardware.camera2.CaptureResult
import android.hardware.camera2.TotalCaptureResult
import android.media.ImageReader
import android.view.Surface
import dev.ml2sensors.source.DropReason

/**
 * Pairs images with capture results as the camera delivers them. Used by the camera's thread only.
 *
 * @param deliver receives an image with its exposure, in order of capture.
 * @param lost receives the reason for each image that will not be delivered.
 * @param fail receives the error after which nothing more is delivered.
 */
internal class CaptureCallbacks(
    private val copier: ImageCopier,
    private val exposures: ExposureReader,
    private val deliver: (image: CopiedImage, exposure: Exposure, captureNanos: Long) -> Unit,
    private val lost: (DropReason) -> Unit,
    private val fail: (Exception) -> Unit,
) : CameraCaptureSession.CaptureCallback(),
    ImageReader.OnImageAvailableListener {
    private val matching = TimestampMatch<CopiedImage, Exposure>(::pair, ::discard)

    private val odd = OddImages(fail)

    override fun onImageAvailable(reader: ImageReader) = guarded {
        try {
            reader.acquireNextImage()?.use { image ->
                copier.copy(image)?.let { matching.image(image.timestamp, it) }
            }
            odd.addUsable()
        } catch (e: RuntimeException) {
            odd.addOdd(e)
            lost(DropReason.UNUSABLE)
        }
    }

    override fun onCaptureFailed(
        session: CameraCaptureSession,
        request: CaptureRequest,
        failure: CaptureFailure,
    ) {
        // Else the image comes and is counted as one without a result
        if (!failure.wasImageCaptured()) lost(DropReason.UNUSABLE)
    }

    override fun onCaptureBufferLost(
        session: CameraCaptureSession,
        request: CaptureRequest,
        target: Surface,
        frameNumber: Long,
    ) = lost(DropReason.UNUSABLE)

    override fun onCaptureCompleted(
        session: CameraCaptureSession,
        request: CaptureRequest,
        result: TotalCaptureResult,
    ) = guarded {
        result.get(CaptureResult.SENSOR_TIMESTAMP)?.let { matching.result(it, exposures.read(result, it)) }
    }

    /** Counts the images that no callback will deliver. Called after the last callback. */
    fun end(reader: ImageReader) {
        matching.end()
        while (true) {
            (reader.acquireNextImage() ?: return).close()
            lost(DropReason.SOURCE_LATE)
        }
    }

    private fun pair(image: CopiedImage, exposure: Exposure) {
        val captureNanos = exposure.captureNanos ?: return discard(image)
        deliver(image, exposure, captureNanos)
    }

    private fun discard(image: CopiedImage) {
        image.discard()
        lost(DropReason.SOURCE_LATE)
    }

    /** Reports exceptions to [fail]: one that leaves a camera callback would end the app. */
    private inline fun guarded(callback: () -> Unit) {
        try {
            callback()
        } catch (e: Exception) {
            fail(e)
        }
    }
}
