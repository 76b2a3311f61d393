package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.capture.NativeColorPoses
import dev.ml2sensors.capture.NativeHeadsetClock
import dev.ml2sensors.simulator.signal.BufferPool
import dev.ml2sensors.simulator.signal.MAX_LATENESS_NANOS
import dev.ml2sensors.simulator.signal.emitAndRelease
import dev.ml2sensors.simulator.signal.waitUntil
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.source.isVideo
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.Job
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withContext
import java.nio.ByteBuffer
import java.util.concurrent.Executors

/**
 * Simulates the colour camera of Android's Camera2: images of the simulated scene, as JPEG or raw for video, with
 * intrinsics and the MLTime of their capture. The pose of the camera comes from the native library, right after the capture.
 */
internal class SimulatedCamera2 : SensorSource {
    private val life = Job()

    override val backend: String get() = "camera2"

    override val streams: Set<StreamSpec> = setOf(StreamTable.color, StreamTable.mixedReality)

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = stream.answer(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
        // Poses must be read on one thread, and the first frame waits for the scene to be built
        Executors.newSingleThreadExecutor().asCoroutineDispatcher().use { thread ->
            // A flow that ends meanwhile loses what withContext returns, but not this
            var opened: ColorPoses.Tracker? = null
            try {
                val camera = withContext(thread) {
                    val poses =
                        checkNotNull(NativeColorPoses.open()) { "the simulated device has the vendor's library" }
                    opened = poses
                    OpenColorCamera(values, stream == StreamTable.mixedReality, poses)
                }
                while (NativeHeadsetClock.waitUntil(camera.nextNanos, life)) {
                    withContext(thread) { camera.next() }.forEach { emitAndRelease(it) }
                }
            } finally {
                withContext(NonCancellable + thread) { opened?.close() }
            }
        }
    }

    /** Ends all flows. */
    override fun close(): Unit = life.cancel()
}

/** An open colour camera. Use it only on the thread that created it, and opened [poses]. */
private class OpenColorCamera(
    private val values: StreamValues,
    private val withHologram: Boolean,
    private val poses: ColorPoses.Tracker,
) {
    private val width = checkNotNull(values.width)
    private val height = checkNotNull(values.height)
    private val numbers = LongArray(NUMBERS)
    private val tag = FloatArray(TAG_NUMBERS)
    private val buffers = BufferPool(width * height * 3 / 2, RAW_IMAGES)
    private val frameNumber get() = numbers[0]
    private val deviceNanos get() = numbers[1]

    /** The time at which [next] has a frame. */
    val nextNanos: Long get() = numbers[3]

    init {
        read(NativeHeadsetClock.nowNanos())
    }

    /** Returns the next frame, preceded by a count of frames that were lost because this call came late. */
    fun next(): List<Sample> {
        val last = frameNumber
        val now = NativeHeadsetClock.nowNanos()
        val jpeg = read(if (now - nextNanos > MAX_LATENESS_NANOS) now else nextNanos)
        val lost = (frameNumber - last - 1).toInt()
        val sample = sample(jpeg)
        if (lost == 0) return listOf(sample)
        return listOf(LostSamples(sample.captureNanos, lost, DropReason.SOURCE_LATE), sample)
    }

    private fun sample(jpeg: ByteBuffer): Sample {
        val captureNanos = poses.captureNanos(deviceNanos)
        if (!values.isVideo) {
            return image(captureNanos, strideBytes = 0, listOf(ImageSample.Plane(ImageSample.IMAGE, jpeg))) {}
        }
        val raw = buffers.acquire() ?: return LostSamples(captureNanos, 1, DropReason.NO_BUFFER)
        SimulatedSdk.colorPixels(jpeg, raw)
        return image(captureNanos, strideBytes = width, planes(raw)) { buffers.release(raw) }
    }

    private fun image(captureNanos: Long, strideBytes: Int, planes: List<ImageSample.Plane>, giveBack: () -> Unit) =
        ImageSample(
            captureNanos,
            frameNumber,
            width,
            height,
            strideBytes,
            poses.poseAt(deviceNanos),
            intrinsics(),
            CaptureMetadata(exposureNanos = numbers[2]),
            planes,
            giveBack,
        )

    private fun planes(nv21: ByteBuffer) = listOf(
        ImageSample.Plane(ImageSample.IMAGE, nv21.duplicate().limit(width * height).slice()),
        ImageSample.Plane(ImageSample.CHROMA, nv21.duplicate().position(width * height).slice()),
    )

    private fun read(boottimeNanos: Long) = checkNotNull(
        SimulatedSdk.color(width, height, checkNotNull(values.rateHz), withHologram, boottimeNanos, numbers, tag),
    ) { "the simulated device has no colour mode ${width}x$height at ${values.rateHz} Hz" }

    /** Decodes com.amd.control.intrinsics: w, h, fx, fy, cx, cy, fov, k1, k2, p1, p2, k3. */
    private fun intrinsics(): Intrinsics {
        val (fx, fy, cx, cy) = List(4) { tag[2 + it].toDouble() }
        val (k1, k2, p1, p2, k3) = List(5) { tag[7 + it].toDouble() }
        return Intrinsics(width, height, fx, fy, cx, cy, Distortion.PlumbBob(k1, k2, p1, p2, k3))
    }

    private companion object {
        const val NUMBERS = 4
        const val TAG_NUMBERS = 12

        /** One that is encoded, and one that is filled meanwhile. */
        const val RAW_IMAGES = 2
    }
}
