package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.Capture
import dev.ml2sensors.simulator.signal.Signal
import dev.ml2sensors.source.BufferPool
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
 * @property planes role of each image of a capture, and how frame numbers are written into it.
 * @property mount in the head, body axes; null when not known, and then [lens] is too.
 * @property draw the images of [planes] at a phase from 0 to 1 of a loop; runs on any thread.
 */
internal class Camera(
    val width: Int,
    val height: Int,
    val strideBytes: Int,
    val planes: Map<String, FrameNumber>,
    val settings: CaptureSettings,
    val lens: Intrinsics? = null,
    val mount: Transform? = null,
    val draw: (phase: Double) -> List<ByteArray>,
)

/** A camera with the loop of images it shows again and again. */
internal class Film(private val camera: Camera, private val reels: List<Reel>) {
    fun signal(rateHz: Int, trajectory: Trajectory) =
        Signal(rateHz) { capture -> sample(capture, trajectory.at(capture.seconds).pose) }

    /** The next image in borrowed memory, taken with the head at [head]. */
    private fun sample(capture: Capture, head: Transform): Sample {
        val lent = reels.mapNotNull { reel -> reel.lend(capture.number)?.let { reel to it } }
        val giveBack = { lent.forEach { (reel, pixels) -> reel.giveBack(pixels) } }
        if (lent.size < reels.size) {
            giveBack()
            return LostSamples(capture.nanos, 1, DropReason.NO_BUFFER)
        }
        return ImageSample(
            capture.nanos,
            capture.number,
            camera.width,
            camera.height,
            camera.strideBytes,
            camera.mount?.let { head * it * OPTICAL_IN_BODY },
            camera.lens,
            camera.settings,
            lent.map { (reel, pixels) -> ImageSample.Plane(reel.role, pixels) },
            giveBack,
        )
    }
}

/** One image of each frame of the loop, and the memory that copies of them are lent in. */
internal class Reel(val role: String, private val mark: FrameNumber, private val images: List<ByteArray>) {
    private val pool = BufferPool(images.maxOf { it.size }, POOL_BUFFERS)

    fun lend(number: Long): ByteBuffer? {
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

/** Draws [frameCount] images of each plane, on as many threads as the dispatcher has. */
internal suspend fun Camera.film(frameCount: Int): Film = coroutineScope {
    val frames = List(frameCount) { async { draw(it.toDouble() / frameCount) } }.awaitAll()
    Film(this@film, planes.entries.mapIndexed { plane, (role, mark) -> Reel(role, mark, frames.map { it[plane] }) })
}
