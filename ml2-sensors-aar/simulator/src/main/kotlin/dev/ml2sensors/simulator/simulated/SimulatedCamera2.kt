package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.capture.NativeColorPoses
import dev.ml2sensors.capture.NativeHeadsetClock
import dev.ml2sensors.simulator.signal.MAX_LATENESS_NANOS
import dev.ml2sensors.simulator.signal.emitAndRelease
import dev.ml2sensors.simulator.signal.waitUntil
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.Job
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withContext
import java.util.concurrent.Executors

/**
 * Simulates the colour camera of Android's Camera2: JPEGs of the simulated scene with intrinsics and the MLTime of their
 * capture. The pose of the camera comes from the native library, right after the capture.
 */
internal class SimulatedCamera2 : SensorSource {
    private val life = Job()

    override val backend: String get() = "camera2"

    override val streams: Set<StreamSpec> = setOf(StreamTable.color, StreamTable.mixedReality)

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = stream.answer(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
        // Poses must be read on one thread, and rendering the first frame takes seconds
        Executors.newSingleThreadExecutor().asCoroutineDispatcher().use { thread ->
            val camera = withContext(thread) { OpenColorCamera(values, stream == StreamTable.mixedReality) }
            try {
                while (NativeHeadsetClock.waitUntil(camera.nextNanos, life)) {
                    withContext(thread) { camera.next() }.forEach { emitAndRelease(it) }
                }
            } finally {
                withContext(NonCancellable + thread) { camera.close() }
            }
        }
    }

    /** Ends all flows. */
    override fun close(): Unit = life.cancel()
}

/** An open colour camera. Use it only on the thread that created it. */
private class OpenColorCamera(private val values: StreamValues, private val withHologram: Boolean) : AutoCloseable {
    private val width = checkNotNull(values.width)
    private val height = checkNotNull(values.height)
    private val numbers = LongArray(NUMBERS)
    private val tag = FloatArray(TAG_NUMBERS)
    private val poses = checkNotNull(NativeColorPoses.open()) { "the simulated device has the vendor's library" }
    private val frameNumber get() = numbers[0]

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
        val deviceNanos = numbers[1]
        val sample = ImageSample(
            poses.captureNanos(deviceNanos),
            frameNumber,
            width,
            height,
            strideBytes = 0,
            poses.poseAt(deviceNanos),
            intrinsics(),
            CaptureSettings(exposureNanos = numbers[2]),
            listOf(ImageSample.Plane(ImageSample.IMAGE, jpeg)),
            giveBack = {},
        )
        val lost = (frameNumber - last - 1).toInt()
        if (lost == 0) return listOf(sample)
        return listOf(LostSamples(sample.captureNanos, lost, DropReason.SOURCE_LATE), sample)
    }

    private fun read(boottimeNanos: Long) = checkNotNull(
        SimulatedSdk.color(width, height, checkNotNull(values.rateHz), withHologram, boottimeNanos, numbers, tag),
    ) { "the simulated device has no colour mode ${width}x$height at ${values.rateHz} Hz" }

    /** Decodes com.amd.control.intrinsics: w, h, fx, fy, cx, cy, fov, k1, k2, p1, p2, k3. */
    private fun intrinsics(): Intrinsics {
        val (fx, fy, cx, cy) = List(4) { tag[2 + it].toDouble() }
        val (k1, k2, p1, p2, k3) = List(5) { tag[7 + it].toDouble() }
        return Intrinsics(width, height, fx, fy, cx, cy, Distortion.PlumbBob(k1, k2, p1, p2, k3))
    }

    override fun close(): Unit = poses.close()

    private companion object {
        const val NUMBERS = 4
        const val TAG_NUMBERS = 12
    }
}
