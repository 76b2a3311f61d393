package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.BufferPool
import dev.ml2sensors.simulator.signal.Capture
import dev.ml2sensors.simulator.signal.Signal
import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.async
import kotlinx.coroutines.awaitAll
import kotlinx.coroutines.coroutineScope
import java.nio.ByteBuffer

/**
 * A camera in one mode.
 *
 * @property strideBytes 0 for JPEG.
 * @property planes the role of each image of a capture, and how frame numbers are written into it.
 * @property lens the intrinsics; null together with [extrinsics].
 * @property extrinsics the pose in the head frame, with body axes; null if not known.
 * @property draw renders the images of [planes] at a phase of the loop, from 0 to 1; runs on any thread.
 */
internal class Camera(
    val width: Int,
    val height: Int,
    val strideBytes: Int,
    val planes: Map<String, FrameNumber>,
    val settings: CaptureSettings,
    val lens: Intrinsics? = null,
    val extrinsics: Transform? = null,
    val draw: (phase: Double) -> List<ByteArray>,
)

/** The rendered frames of a camera, which it shows in a loop. */
internal class FrameLoop(private val camera: Camera, private val planeLoops: List<PlaneLoop>) {
    fun signal(rateHz: Int, trajectory: Trajectory) =
        Signal(rateHz) { capture -> sample(capture, trajectory.at(capture.seconds).pose) }

    /** Returns the next image in leased memory, captured with the head at [head]. */
    private fun sample(capture: Capture, head: Transform): Sample {
        val leased = planeLoops.mapNotNull { planeLoop -> planeLoop.lease(capture.number)?.let { planeLoop to it } }
        val giveBack = { leased.forEach { (planeLoop, pixels) -> planeLoop.giveBack(pixels) } }
        if (leased.size < planeLoops.size) {
            giveBack()
            return LostSamples(capture.nanos, 1, DropReason.NO_BUFFER)
        }
        return ImageSample(
            capture.nanos,
            capture.number,
            camera.width,
            camera.height,
            camera.strideBytes,
            camera.extrinsics?.let { head * it * OPTICAL_IN_BODY },
            camera.lens,
            camera.settings,
            leased.map { (planeLoop, pixels) -> ImageSample.Plane(planeLoop.role, pixels) },
            giveBack,
        )
    }
}

/** One plane of all frames of a loop, and the buffers in which copies of it are leased. */
internal class PlaneLoop(val role: String, private val mark: FrameNumber, private val images: List<ByteArray>) {
    private val pool = BufferPool(images.maxOf { it.size }, POOL_BUFFERS)

    fun lease(number: Long): ByteBuffer? {
        val pixels = pool.acquire() ?: return null
        pixels.put(images[(number % images.size).toInt()]).flip()
        mark.write(pixels, number)
        return pixels
    }

    fun giveBack(pixels: ByteBuffer): Unit = pool.release(pixels)

    private companion object {
        const val POOL_BUFFERS = 8
    }
}

/** Renders [frameCount] images of each plane, on as many threads as the dispatcher has. */
internal suspend fun Camera.renderLoop(frameCount: Int): FrameLoop = coroutineScope {
    val frames = List(frameCount) { async { draw(it.toDouble() / frameCount) } }.awaitAll()
    FrameLoop(
        this@renderLoop,
        planes.entries.mapIndexed { plane, (role, mark) ->
            PlaneLoop(role, mark, frames.map { it[plane] })
        },
    )
}
