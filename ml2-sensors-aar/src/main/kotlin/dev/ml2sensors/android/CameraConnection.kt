package dev.ml2sensors.android

import android.content.Context
import android.hardware.camera2.CameraCaptureSession
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureRequest
import android.os.Handler
import android.util.Log
import android.view.Surface
import dev.ml2sensors.source.SourceException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.withContext

/**
 * One camera from opening to closing. Everything but [fail] runs on the thread of [handler], which outlives [close].
 *
 * @param end completes when the camera is to be closed; fails when the camera fails.
 */
internal class CameraConnection(
    private val context: Context,
    private val id: String,
    private val handler: Handler,
    private val end: CompletableDeferred<Unit>,
) : CameraDevice.StateCallback() {
    private val opened = CompletableDeferred<CameraDevice>()
    private val configured = CompletableDeferred<CameraCaptureSession>()
    private val closed = CompletableDeferred<Unit>()
    private var isRequested = false
    private var device: CameraDevice? = null

    /**
     * Opens the camera and starts the repeating [request], whose images go to [surface].
     *
     * @throws SourceException when the camera cannot be opened.
     */
    suspend fun start(
        surface: Surface,
        results: CameraCaptureSession.CaptureCallback,
        request: (CameraDevice) -> CaptureRequest,
    ) {
        accessing { context.getSystemService(CameraManager::class.java).openCamera(id, this, handler) }
        isRequested = true
        val device = opened.await()
        if (end.isCompleted) return
        accessing { device.createCaptureSession(listOf(surface), SessionCallback(), handler) }
        val session = configured.await()
        accessing { session.setRepeatingRequest(request(device), results, handler) }
    }

    /** Fails everything that waits for this camera with [cause]. Thread-safe. */
    fun fail(cause: Exception) {
        opened.completeExceptionally(cause)
        configured.completeExceptionally(cause)
        end.completeExceptionally(cause)
    }

    /** Closes the camera, and returns after its last callback. */
    suspend fun close(): Unit = withContext(NonCancellable) {
        if (!isRequested) return@withContext
        // The answer comes in any case
        opened.join()
        try {
            device?.close()
        } catch (e: RuntimeException) { // Then it does not say that it is closed
            Log.w("ml2s", "camera $id cannot be closed: ${e.message}")
            closed.complete(Unit)
        }
        closed.await()
    }

    override fun onOpened(camera: CameraDevice) {
        device = camera
        opened.complete(camera)
    }

    override fun onDisconnected(camera: CameraDevice) {
        device = camera
        fail(SourceException("camera $id was taken away: another use has priority, or the app is not in front"))
    }

    override fun onError(camera: CameraDevice, error: Int) {
        device = camera
        fail(SourceException("camera $id failed: ${nameOf(error)}"))
    }

    override fun onClosed(camera: CameraDevice) {
        closed.complete(Unit)
    }

    private inline fun <T> accessing(access: () -> T): T = ofAndroid("camera $id cannot be used", access)

    private fun nameOf(error: Int) =
        when (error) {
            ERROR_CAMERA_IN_USE -> "it is in use"
            ERROR_MAX_CAMERAS_IN_USE -> "too many cameras are in use"
            ERROR_CAMERA_DISABLED -> "it is disabled by policy"
            ERROR_CAMERA_DEVICE -> "error of the device"
            ERROR_CAMERA_SERVICE -> "error of the camera service"
            else -> "error $error"
        }

    private inner class SessionCallback : CameraCaptureSession.StateCallback() {
        override fun onConfigured(session: CameraCaptureSession) {
            configured.complete(session)
        }

        override fun onConfigureFailed(session: CameraCaptureSession) =
            fail(SourceException("camera $id refused the capture configuration"))
    }
}
