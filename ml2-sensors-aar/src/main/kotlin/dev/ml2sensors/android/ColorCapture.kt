package dev.ml2sensors.android

import android.content.Context
import android.graphics.ImageFormat
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CaptureRequest
import android.media.ImageReader
import android.os.Handler
import android.os.HandlerThread
import android.os.Process
import dev.ml2sensors.capture.LocalFrames
import dev.ml2sensors.capture.SampleQueue
import dev.ml2sensors.capture.Slot
import dev.ml2sensors.capture.SlotPool
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineDispatcher
import kotlinx.coroutines.CoroutineExceptionHandler
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.Job
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.launch
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeoutOrNull
import java.util.concurrent.Executor
import kotlin.time.Duration.Companion.seconds

/**
 * One run of a camera for one collector. A camera thread copies the images, [workers] encode them to JPEG unless they are
 * for video, and the collector receives them in order of capture. It ends with [ended].
 *
 * Its memory is bounded. At most [SlotPool.SLOTS] JPEGs of one byte per pixel, or raw images of 1.5, are outside of Java's
 * heap, mapped when first needed; a page of them takes memory once a JPEG has reached it. If [workers] encode, [YuvCopier] has arrays of
 * 1.5 bytes per pixel in the heap, one more than workers. The camera has [CAMERA_IMAGES] images of its own. At
 * 4096 x 3072 with 4 workers that is 101 MB and 94 MB.
 */
internal class ColorCapture(
    private val stream: StreamSpec,
    private val context: Context,
    private val camera: ColorCamera,
    private val plan: CapturePlan,
    private val rateHz: Int,
    private val encoder: JpegEncoder,
    private val workers: EncoderThreads,
    private val ended: Job,
    private val clock: DeviceClock,
    private val exposures: (CameraTracker) -> ExposureReader,
) {
    private val width = plan.size.width
    private val height = plan.size.height

    /** One byte per pixel: at quality 90 even noise takes less. */
    private val mostJpegBytes = width * height
    private val queue = SampleQueue(QUEUED_FRAMES)
    private val order = CaptureOrder(queue)

    /** Completes when the camera is to be closed; fails with the first reason for which the run fails. */
    private val end = CompletableDeferred<Unit>()

    /** Ends with the camera's last callback. */
    @Volatile
    private var run: Job? = null

    /** Not cancelled with the collector: an image that was copied is always encoded, and returns its memory. */
    private val encoding = Job()

    /**
     * Delivers every image that the camera delivers, or counts it, also when the run fails. Returns when the camera is
     * closed, or has not been for [CLOSING]: then the run is left behind, and the failure says so.
     */
    suspend fun deliverTo(collector: FlowCollector<Sample>, poses: ColorPoses): Unit =
        coroutineScope {
            // Not a child, so that a camera that never answers does not keep the collector
            val run = CoroutineScope(
                Dispatchers.Default + CoroutineExceptionHandler { _, e ->
                    queue.close(e)
                },
            ).launch {
                queue.closeAfter {
                    SlotPool(stream).use { slots -> onThreadOfItsOwn { capture(it, copier(slots), poses) } }
                }
            }
            this@ColorCapture.run = run
            val ending = ended.invokeOnCompletion { end.complete(Unit) }
            var isLeft = false
            val closing = launch {
                end.join()
                isLeft = withTimeoutOrNull(CLOSING) { run.join() } == null
                if (isLeft) queue.close(stuck())
            }
            try {
                queue.deliverTo(collector)
            } finally {
                ending.dispose()
                closing.cancel()
                run.cancel()
                // Not waited for twice, else the silence meanwhile would become the reason
                if (!isLeft) withContext(NonCancellable) { withTimeoutOrNull(CLOSING) { run.join() } }
            }
        }

    /** @throws SourceException while the camera has not let go of a run that was left behind. */
    fun checkEnded() {
        if (run?.isCompleted == false) throw stuck()
    }

    /** Returns what says that the run is left behind, after the reason for which it was to end. */
    @OptIn(ExperimentalCoroutinesApi::class) // getCompletionExceptionOrNull
    private fun stuck(): SourceException {
        val failure = if (end.isCompleted) end.getCompletionExceptionOrNull() else null
        val reason = failure.takeIf { it !is CancellationException }
        val left =
            "the last run of camera ${camera.id} has not ended: the camera, its pose tracker or its encoder does " +
                "not answer; it is used again when they do; if that lasts, restart the headset"
        return SourceException(listOfNotNull(reason?.message, left).joinToString("; "))
    }

    private fun copier(slots: SlotPool): ImageCopier = when {
        plan.isRaw -> RawCopier(width, height, slots, ::lose)
        plan.format == ImageFormat.JPEG -> JpegCopier(slots, mostJpegBytes, ::lose)
        else -> YuvCopier(width, height, encoder, workers.count, slots, mostJpegBytes, ::lose)
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

    private suspend fun capture(handler: Handler, copier: ImageCopier, poses: ColorPoses) =
        CameraTracker(poses, clock).use {
            it.open()
            capture(handler, copier, exposures(it))
        }

    private suspend fun capture(handler: Handler, copier: ImageCopier, exposures: ExposureReader) {
        val connection = CameraConnection(context, camera.id, handler, end)
        val odd = OddImages(connection::fail)
        val thinning = Thinning(rateHz)
        val deliver = { image: CopiedImage, exposure: Exposure, captureNanos: Long ->
            if (thinning.admits(captureNanos)) {
                val place = order.add()
                CoroutineScope(workers.dispatcher + encoding).launch {
                    val sample = sample(image, exposure, captureNanos, odd)
                    order.put(place, sample?.let { Captured(image.slot, it) })
                }
            } else {
                image.discard()
            }
            Unit
        }
        val run = CaptureCallbacks(copier, exposures, deliver, ::lose, connection::fail)
        ImageReader.newInstance(width, height, plan.format, CAMERA_IMAGES).use { reader ->
            try {
                reader.setOnImageAvailableListener(run, handler)
                connection.start(reader.surface, run) { request(it, reader) }
                end.await()
            } catch (e: Exception) {
                end.completeExceptionally(e)
                throw e
            } finally {
                connection.close()
                run.end(reader)
                encoding.complete()
                withContext(NonCancellable) { encoding.join() }
            }
        }
    }

    private fun request(device: CameraDevice, reader: ImageReader): CaptureRequest =
        device.createCaptureRequest(CameraDevice.TEMPLATE_RECORD).apply {
            addTarget(reader.surface)
            set(CaptureRequest.CONTROL_AE_TARGET_FPS_RANGE, camera.fpsRange(rateHz))
            VendorRequest.of(camera.id)?.let { it.setIn(this) }
            if (plan.format == ImageFormat.JPEG) set(CaptureRequest.JPEG_QUALITY, JpegEncoder.QUALITY.toByte())
        }.build()

    /** Returns null if there is no image, which is counted. */
    private fun sample(
        image: CopiedImage,
        exposure: Exposure,
        captureNanos: Long,
        odd: OddImages,
    ): ImageSample? {
        val slot = image.slot
        if (!isEncoded(image, odd)) {
            slot.release()
            return null
        }
        return ImageSample(
            captureNanos,
            exposure.frameNumber,
            width,
            height,
            strideBytes = if (plan.isRaw) width else 0,
            exposure.pose,
            exposure.intrinsics,
            // Android's sensitivity is no gain: what of it is analog, and over which base, it does not say
            CaptureMetadata(exposure.exposureNanos, stampSource = exposure.stampSource),
            planes(slot),
            giveBack = slot::release,
        )
    }

    private fun planes(slot: Slot): List<ImageSample.Plane> {
        if (!plan.isRaw) return listOf(ImageSample.Plane(ImageSample.IMAGE, slot.bytes))
        val luma = slot.bytes.duplicate().limit(width * height).slice()
        val chroma = slot.bytes.duplicate().position(width * height).slice()
        return listOf(ImageSample.Plane(ImageSample.IMAGE, luma), ImageSample.Plane(ImageSample.CHROMA, chroma))
    }

    private fun isEncoded(image: CopiedImage, odd: OddImages): Boolean = try {
        val fits = image.encode()
        odd.addUsable()
        if (!fits) lose(DropReason.NO_BUFFER)
        fits
    } catch (e: Exception) {
        odd.addOdd(e)
        lose(DropReason.UNUSABLE)
        false
    }

    private fun lose(reason: DropReason): Unit = queue.countLost(1, reason)

    private companion object {
        /** One image that is copied, and those that arrive meanwhile. */
        const val CAMERA_IMAGES = 3
        const val QUEUED_FRAMES = 2

        /** The longest time that a camera may take to close. */
        val CLOSING = 2.seconds
    }
}

/** A [sample] in its [slot]. */
private class Captured(val slot: Slot, val sample: ImageSample)

/** Passes images that several threads encode to [queue], in the order of [add], and publishes JPEGs. Thread-safe. */
private class CaptureOrder(private val queue: SampleQueue) {
    class Place(var isDone: Boolean = false, var image: Captured? = null)

    private val places = ArrayDeque<Place>()

    /** Returns the place of the next image. */
    fun add(): Place = Place().also { synchronized(places) { places += it } }

    /** Puts [image] at its [place]; null if there is none. */
    fun put(place: Place, image: Captured?): Unit = synchronized(places) {
        place.image = image
        place.isDone = true
        while (places.firstOrNull()?.isDone == true) {
            val next = places.removeFirst().image ?: continue
            val isJpeg = next.sample.strideBytes == 0
            if (isJpeg) LocalFrames.publish(next.slot, next.sample)
            queue.offer(next.sample)
        }
    }
}

/** [count] encoder threads; by default half of the processors, since others capture and send. */
internal class EncoderThreads(val count: Int = maxOf(1, Runtime.getRuntime().availableProcessors() / 2)) {
    /** An encoder that never returns blocks none of the threads of [Dispatchers.Default]. */
    val dispatcher: CoroutineDispatcher = Dispatchers.IO.limitedParallelism(count)
}
