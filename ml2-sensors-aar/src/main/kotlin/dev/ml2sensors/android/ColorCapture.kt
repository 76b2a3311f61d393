package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureRequest
import android.media.ImageReader
import android.os.Handler
import android.os.HandlerThread
import android.os.Process
import dev.ml2sensors.capture.SampleQueue
import dev.ml2sensors.source.BufferPool
import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineDispatcher
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.async
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.launch
import kotlinx.coroutines.withContext
import java.util.concurrent.Executor

/**
 * One run of a camera for one collector. A camera thread copies the images, [workers] encode them to JPEG, and the
 * collector receives them in order of capture. It ends with [ended].
 */
internal class ColorCapture(
    private val cameraManager: CameraManager,
    private val camera: ColorCamera,
    private val plan: CapturePlan,
    private val rateHz: Int,
    encoder: JpegEncoder,
    private val workers: EncoderThreads,
    private val ended: Job,
    private val clock: DeviceClock,
    private val exposures: (CameraTracker) -> ExposureReader,
) {
    private val width = plan.size.width
    private val height = plan.size.height

    /** Buffers of one byte per pixel: at quality 90 even noise takes less. */
    private val pool = BufferPool(bufferBytes = width * height, JPEGS)
    private val copier =
        if (plan.format == ImageFormat.JPEG) {
            JpegCopier(pool, ::lose)
        } else {
            YuvCopier(width, height, encoder, workers.count, pool, ::lose)
        }

    /** The samples in order of capture. [copier] bounds their number. */
    private val samples = Channel<Deferred<Sample>>(Channel.UNLIMITED)
    private val queue = SampleQueue(QUEUED_FRAMES)
    private val odd = OddImages()

    suspend fun deliverTo(collector: FlowCollector<Sample>, poses: ColorPoses): Unit = coroutineScope {
        launch(Dispatchers.Default) { for (sample in samples) queue.offer(sample.await()) }
        launch {
            onThreadOfItsOwn { handler -> capture(this@coroutineScope, handler, poses) }
            queue.close(cause = null)
        }
        queue.deliverTo(collector)
        coroutineContext.cancelChildren()
    }

    private suspend fun onThreadOfItsOwn(block: suspend (Handler) -> Unit) {
        val thread = HandlerThread("ml2s-camera-${camera.id}", Process.THREAD_PRIORITY_DISPLAY).apply { start() }
        val handler = Handler(thread.looper)
        try {
            withContext(Executor { check(handler.post(it)) }.asCoroutineDispatcher()) {
                block(handler)
            }
        } finally {
            thread.quitSafely()
        }
    }

    private suspend fun capture(scope: CoroutineScope, handler: Handler, poses: ColorPoses) =
        CameraTracker(poses, clock).use {
            it.open()
            capture(scope, handler, exposures(it))
        }

    private suspend fun capture(scope: CoroutineScope, handler: Handler, exposures: ExposureReader) {
        val connection = CameraConnection(cameraManager, camera.id, handler)
        val reader = ImageReader.newInstance(width, height, plan.format, CAMERA_IMAGES)
        val ending = ended.invokeOnCompletion { connection.end.complete(Unit) }
        val deliver = { image: CopiedImage, exposure: Exposure, captureNanos: Long ->
            samples.trySend(scope.async(workers.dispatcher) { sample(image, exposure, captureNanos) })
            Unit
        }
        val run = CaptureCallbacks(copier, exposures, deliver, ::lose, connection::fail)
        try {
            reader.setOnImageAvailableListener(run, handler)
            connection.start(reader.surface, run) { request(it, reader) }
            connection.end.await()
        } finally {
            ending.dispose()
            connection.close()
            reader.close()
        }
    }

    private fun request(device: CameraDevice, reader: ImageReader): CaptureRequest =
        device.createCaptureRequest(CameraDevice.TEMPLATE_RECORD).apply {
            addTarget(reader.surface)
            set(CaptureRequest.CONTROL_AE_TARGET_FPS_RANGE, camera.fpsRange(rateHz))
            if (plan.format == ImageFormat.JPEG) set(CaptureRequest.JPEG_QUALITY, JpegEncoder.QUALITY.toByte())
        }.build()

    private fun sample(image: CopiedImage, exposure: Exposure, captureNanos: Long): Sample {
        val jpeg = image.jpeg
        val lost = encode(image)
        if (lost != null) {
            pool.release(jpeg)
            return LostSamples(captureNanos, 1, lost)
        }
        return ImageSample(
            captureNanos,
            exposure.frameNumber,
            width,
            height,
            strideBytes = 0,
            exposure.pose,
            exposure.intrinsics,
            // Android's sensitivity is no gain: what of it is analog, and over which base, it does not say
            CaptureSettings(exposure.exposureNanos, stampSource = exposure.stampSource),
            listOf(ImageSample.Plane(ImageSample.IMAGE, jpeg)),
        ) { pool.release(jpeg) }
    }

    /** Returns why there is no JPEG, or null if there is one. */
    private fun encode(image: CopiedImage): DropReason? = try {
        val fits = image.encode()
        odd.addUsable()
        if (fits) null else DropReason.NO_BUFFER
    } catch (e: SourceException) {
        odd.addOdd(e)
        DropReason.UNUSABLE
    }

    private fun lose(reason: DropReason) {
        samples.trySend(CompletableDeferred(LostSamples(clock.nowNanos(), 1, reason)))
    }

    private companion object {
        /** One image that is copied, and those that arrive meanwhile. */
        const val CAMERA_IMAGES = 3
        const val QUEUED_FRAMES = 2

        /** The queue of the image lane, [QUEUED_FRAMES], one that is sent and one that is encoded. */
        const val JPEGS = 8
    }
}

/** [count] encoder threads; by default half of the processors, since others capture and send. */
internal class EncoderThreads(val count: Int = maxOf(1, Runtime.getRuntime().availableProcessors() / 2)) {
    val dispatcher: CoroutineDispatcher = Dispatchers.Default.limitedParallelism(count)
}
