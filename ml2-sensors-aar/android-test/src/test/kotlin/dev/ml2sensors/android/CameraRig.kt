package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.hardware.camera2.CameraCaptureSession
import android.hardware.camera2.CameraCharacteristics
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureFailure
import android.hardware.camera2.CaptureRequest
import android.hardware.camera2.CaptureResult
import android.hardware.camera2.TotalCaptureResult
import android.hardware.camera2.params.StreamConfiguration
import android.hardware.camera2.params.StreamConfigurationDuration
import android.hardware.camera2.params.StreamConfigurationMap
import android.media.Image
import android.media.ImageReader
import android.os.Handler
import android.util.Range
import android.util.Size
import android.view.Surface
import dev.ml2sensors.TEST_LIMIT
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.withTimeout
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import org.robolectric.annotation.RealObject
import org.robolectric.shadow.api.Shadow
import org.robolectric.shadows.ShadowCameraCaptureSessionImpl
import org.robolectric.shadows.ShadowCameraCharacteristics
import org.robolectric.shadows.ShadowCameraDeviceImpl
import org.robolectric.shadows.ShadowCameraManager
import org.robolectric.shadows.ShadowCaptureResult
import org.robolectric.shadows.ShadowImageReader
import org.robolectric.util.ReflectionHelpers
import org.robolectric.util.ReflectionHelpers.ClassParameter
import java.lang.ref.WeakReference
import java.util.Queue
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.ConcurrentLinkedQueue
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.CountDownLatch
import java.util.concurrent.Executor
import java.util.concurrent.atomic.AtomicBoolean

/** A size in which a camera delivers [format], how long a frame takes at least, and how long it holds up others. */
internal class Mode(val format: Int, val size: Size, val minNanos: Long, val stallNanos: Long = 0)

/** Cameras below Android's own Camera2; what they deliver is up to the test. */
internal class CameraRig(private val manager: CameraManager) {
    private var frames = 0L

    fun add(
        id: String,
        modes: List<Mode>,
        fps: List<Pair<Int, Int>> = listOf(15 to 15, 15 to 30, 30 to 30, 60 to 60),
        timestampSource: Int = CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE_UNKNOWN,
    ) {
        val camera = ShadowCameraCharacteristics.newCameraCharacteristics()
        // Every camera has this mode
        val opaque = Mode(ImageFormat.PRIVATE, modes.first().size, minNanos = 0)
        shadowOf(camera).apply {
            set(CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP, mapOf(modes + opaque))
            set(
                CameraCharacteristics.CONTROL_AE_AVAILABLE_TARGET_FPS_RANGES,
                fps.map { (lower, upper) -> Range(lower, upper) }.toTypedArray(),
            )
            set(CameraCharacteristics.SENSOR_INFO_TIMESTAMP_SOURCE, timestampSource)
        }
        shadowOf(manager).addCamera(id, camera)
    }

    /**
     * A capture session that has been asked to deliver. Each delivery happens on the thread of the callbacks, and
     * returns false if the camera was closed before.
     */
    class Running(
        val session: CameraCaptureSession,
        val request: CaptureRequest,
        private val callback: CameraCaptureSession.CaptureCallback,
        val handler: Handler,
    ) {
        private val camera = opened

        /** True if the product has closed the camera, for everything that it has been told so far. */
        val isClosed: Boolean get() = !deliver {}

        fun complete(result: TotalCaptureResult): Boolean = deliver { completeHere(result) }

        /** As [complete], on the thread of the callbacks. */
        fun completeHere(result: TotalCaptureResult) {
            if (!camera.isClosed) callback.onCaptureCompleted(session, request, result)
        }

        /** Reports a capture that failed before its image was captured, or after. */
        fun fail(wasImageCaptured: Boolean): Boolean = deliver {
            val failure = Shadow.newInstanceOf(CaptureFailure::class.java)
            ReflectionHelpers.setField(failure, "mDropped", !wasImageCaptured)
            callback.onCaptureFailed(session, request, failure)
        }

        fun loseBuffer(): Boolean = deliver {
            callback.onCaptureBufferLost(session, request, readers.single().reader.surface, 0)
        }

        fun deliver(image: Image): Boolean = deliver {
            val queue = readers.single()
            queue.images += image
            queue.announce()
        }

        /** Tells of an image that is gone when it is looked for, when the thread of the callbacks has time. */
        fun postAnnouncement(): Boolean = handler.post { if (!camera.isClosed) readers.singleOrNull()?.announce() }

        private fun deliver(callback: () -> Unit): Boolean {
            var isDelivered = false
            handler.runAndWait {
                isDelivered = !camera.isClosed
                if (isDelivered) callback()
            }
            return isDelivered
        }
    }

    fun remove(id: String): Unit = shadowOf(manager).removeCamera(id)

    /** Waits until a camera is asked to deliver. */
    suspend fun awaitRunning(): Running = withTimeout(TEST_LIMIT) { running.receive() }

    /** Returns the next session that has been asked to deliver, or null if there is none. */
    fun nextRunning(): Running? = running.tryReceive().getOrNull()

    /** The number of cameras that were opened and are not closed. */
    fun countOpen(): Int {
        unclosed.removeIf { it.isClosed }
        return unclosed.size
    }

    /** Answers the openings that were held. */
    fun answerOpenings() {
        holdsOpenings = false
        heldOpenings.doAll()
    }

    /** Configures the sessions that were held. */
    fun answerSessions() {
        holdsSessions = false
        heldSessions.doAll()
    }

    /** Lets the cameras that were closed say so. */
    fun answerClosings() {
        holdsClosings = false
        heldClosings.doAll()
    }

    /** Delivers an image to the only reader, and waits until its listener has run. */
    fun Running.image(image: Image): Boolean = deliver(image).also { handler.runAndWait {} }

    /** Delivers the result of the next frame. */
    fun Running.result(timestamp: Long, exposureNanos: Long? = null, tags: Map<String, Any> = emptyMap()): Boolean =
        complete(newResult(timestamp, exposureNanos, tags))

    /** As [result], on the thread of the callbacks. */
    fun Running.resultHere(timestamp: Long, exposureNanos: Long?, tags: Map<String, Any>): Unit =
        completeHere(newResult(timestamp, exposureNanos, tags))

    private fun newResult(timestamp: Long, exposureNanos: Long?, tags: Map<String, Any>): TotalCaptureResult {
        val result = Shadow.newInstanceOf(TotalCaptureResult::class.java)
        ReflectionHelpers.setField(result, "mFrameNumber", frames++)
        val values =
            mapOf("android.sensor.timestamp" to timestamp, "android.sensor.exposureTime" to exposureNanos) + tags
        Shadow.extract<TaggedResult>(result).values = values
        return result
    }

    private fun mapOf(modes: List<Mode>) = StreamConfigurationMap(
        modes.map { StreamConfiguration(it.halFormat, it.size.width, it.size.height, false) }.toTypedArray(),
        modes.map { it.duration(it.minNanos) }.toTypedArray(),
        modes.map { it.duration(it.stallNanos) }.toTypedArray(),
        null, null, null, null, null, null, null, null, null, null, null, false,
    )

    private val Mode.halFormat: Int get() = if (format == ImageFormat.JPEG) HAL_PIXEL_FORMAT_BLOB else format

    private fun Mode.duration(nanos: Long) = StreamConfigurationDuration(halFormat, size.width, size.height, nanos)

    /** Opens cameras as told. */
    @Implements(CameraManager::class)
    class Manager : ShadowCameraManager() {
        @Implementation
        public override fun getCameraIdList(): Array<String> {
            pass("CameraManager.getCameraIdList")
            return super.getCameraIdList()
        }

        @Implementation
        public override fun getCameraCharacteristics(id: String): CameraCharacteristics {
            pass("CameraManager.getCameraCharacteristics")
            return super.getCameraCharacteristics(id)
        }

        @Implementation
        override fun openCameraDeviceUserAsync(
            id: String,
            callback: CameraDevice.StateCallback,
            executor: Executor,
            uid: Int,
        ): CameraDevice {
            pass("CameraManager.openCamera")
            failure?.let { throw it }
            val isAnswered = AtomicBoolean()
            val answering = Executor { command ->
                if (isAnswered.getAndSet(true)) executor.execute(command) else answer(executor, command)
            }
            return super.openCameraDeviceUserAsync(id, callback, answering, uid).also { device ->
                opened = Opened(device, callback, executor).also(unclosed::add)
            }
        }

        /** Answers an opening, of which [success] tells. */
        private fun answer(executor: Executor, success: Runnable) {
            val error = openError
            val answer = {
                executor.execute { if (error == null) success.run() else opened.answer(error) }
            }
            heldOpenings.putWhile({ holdsOpenings }, answer)
        }
    }

    /** An opened camera. */
    class Opened(
        private val device: CameraDevice,
        private val callback: CameraDevice.StateCallback,
        private val executor: Executor,
    ) {
        fun disconnect(): Unit = executor.execute { callback.onDisconnected(device) }

        fun fail(error: Int): Unit = executor.execute { callback.onError(device, error) }

        /** Tells of [error], or with [DISCONNECTED] that the camera was taken away, on the thread of the callbacks. */
        fun answer(error: Int): Unit =
            if (error == DISCONNECTED) callback.onDisconnected(device) else callback.onError(device, error)

        val isClosed: Boolean get() = ReflectionHelpers.getField<AtomicBoolean>(device, "mClosing").get()
    }

    /** Refuses sessions as told. */
    @Implements(className = "android.hardware.camera2.impl.CameraDeviceImpl")
    class Device : ShadowCameraDeviceImpl() {
        @RealObject
        lateinit var device: CameraDevice

        @Implementation
        override fun close() {
            pass("CameraDevice.close")
            if (!holdsClosings) return super.close()
            ReflectionHelpers.getField<AtomicBoolean>(device, "mClosing").set(true)
            heldClosings.putWhile({ holdsClosings }) { super.close() }
        }

        @Implementation
        override fun createCaptureRequest(template: Int): CaptureRequest.Builder {
            pass("CameraDevice.createCaptureRequest")
            return super.createCaptureRequest(template)
        }

        @Implementation
        override fun createCaptureSession(
            outputs: List<Surface>,
            callback: CameraCaptureSession.StateCallback,
            handler: Handler,
        ) {
            pass("CameraDevice.createCaptureSession")
            if (holdsSessions) {
                val isClosed = ReflectionHelpers.getField<AtomicBoolean>(device, "mClosing")
                return heldSessions.putWhile({ holdsSessions }) {
                    if (!isClosed.get()) super.createCaptureSession(outputs, callback, handler)
                }
            }
            if (!refusesSessions) return super.createCaptureSession(outputs, callback, handler)
            val type = Class.forName("android.hardware.camera2.impl.CameraCaptureSessionImpl")
            handler.post { callback.onConfigureFailed(Shadow.newInstanceOf(type) as CameraCaptureSession) }
        }
    }

    /** Takes the request of a session. */
    @Implements(className = "android.hardware.camera2.impl.CameraCaptureSessionImpl")
    class Session : ShadowCameraCaptureSessionImpl() {
        @RealObject
        lateinit var session: CameraCaptureSession

        @Implementation
        override fun setRepeatingRequest(
            request: CaptureRequest,
            callback: CameraCaptureSession.CaptureCallback,
            handler: Handler,
        ): Int {
            pass("CameraCaptureSession.setRepeatingRequest")
            requestFailure?.let { throw it }
            running.trySend(Running(session, request, callback, handler))
            return 1
        }
    }

    /** Has the images that the test puts into it. */
    @Implements(ImageReader::class)
    class Reader : ShadowImageReader() {
        @RealObject
        lateinit var reader: ImageReader
        val images = ConcurrentLinkedQueue<Image>()

        @Implementation
        fun acquireNextImage(): Image? {
            pass("ImageReader.acquireNextImage")
            return images.poll()
        }

        /** Tells the listener of an image. */
        fun announce() {
            val post = ClassParameter.from(Any::class.java, WeakReference(reader))
            ReflectionHelpers.callStaticMethod<Unit>(ImageReader::class.java, "postEventFromNative", post)
        }

        @Implementation
        override fun nativeGetSurface(): Surface {
            pass("ImageReader.newInstance")
            return super.nativeGetSurface().also { readers += this }
        }

        @Implementation
        override fun close() {
            readers -= this
            super.close()
        }
    }

    /** Throws for an unknown tag of a vendor, as the framework does, and a value that is an exception. */
    @Implements(CaptureResult::class)
    open class TaggedResult : ShadowCaptureResult() {
        var values: Map<String, Any?> = emptyMap()

        @Implementation
        @Suppress("UNCHECKED_CAST")
        fun <T> get(key: CaptureResult.Key<T>): T? {
            require(key.name.startsWith("android.") || key.name in values) {
                "Could not find tag for key '${key.name}'"
            }
            return values[key.name].also { if (it is RuntimeException) throw it } as T?
        }
    }

    @Implements(TotalCaptureResult::class)
    class TaggedTotalResult : TaggedResult()

    companion object {
        /** Format of JPEG below the framework: system/graphics.h. */
        private const val HAL_PIXEL_FORMAT_BLOB = 0x21
        private val running = Channel<Running>(Channel.UNLIMITED)

        /** The failure of opening any camera. */
        @Volatile
        var failure: Exception? = null

        /** In place of an error code: the camera was taken away. */
        const val DISCONNECTED = -1

        /** The error code that answers an opening, or [DISCONNECTED]; null if a camera opens. */
        @Volatile
        var openError: Int? = null

        /** The exceptions that calls throw, by the names of [NeverReturns.CALLS]. */
        val failures = ConcurrentHashMap<String, Exception>()

        /** Stands where Camera2 carries out [call]. */
        private fun pass(call: String) {
            NeverReturns.pass(call)
            failures[call]?.let { throw it }
        }

        /** True while openings are not answered. */
        @Volatile
        var holdsOpenings = false

        /** True while cameras that are closed do not say so. */
        @Volatile
        var holdsClosings = false
        private val heldClosings = ConcurrentLinkedQueue<() -> Unit>()
        private val unclosed = CopyOnWriteArrayList<Opened>()
        private val heldOpenings = ConcurrentLinkedQueue<() -> Unit>()

        @Volatile
        var refusesSessions = false

        /** True while sessions are neither configured nor refused. */
        @Volatile
        var holdsSessions = false
        private val heldSessions = ConcurrentLinkedQueue<() -> Unit>()

        /** The failure of asking any session to deliver. */
        @Volatile
        var requestFailure: Exception? = null

        /** True if a session has been neither configured nor refused. */
        val isSessionHeld: Boolean get() = heldSessions.isNotEmpty()

        /** True if an opening has not been answered. */
        val isOpeningHeld: Boolean get() = heldOpenings.isNotEmpty()

        /** The latest. */
        @Volatile
        lateinit var opened: Opened

        /** The readers that are open. */
        val readers = CopyOnWriteArrayList<Reader>()

        /** Does [action] when [isHeld] returns false, which may be while this puts it. */
        private fun Queue<() -> Unit>.putWhile(isHeld: () -> Boolean, action: () -> Unit) {
            if (!isHeld()) return action()
            this += action
            if (!isHeld()) doAll()
        }

        private fun Queue<() -> Unit>.doAll() {
            while (true) (poll() ?: return)()
        }

        /** Runs [action] on the thread of this handler, unless the end of the capture has ended that. */
        private fun Handler.runAndWait(action: () -> Unit) {
            val done = CountDownLatch(1)
            val isPosted = post {
                action()
                done.countDown()
            }
            if (!isPosted) return
            done.await()
        }
    }
}
