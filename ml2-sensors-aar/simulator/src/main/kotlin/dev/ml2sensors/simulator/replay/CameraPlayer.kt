package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.times
import dev.ml2sensors.simulator.signal.BufferPool
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.ImageSample
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.runInterruptible
import java.io.File
import java.nio.ByteBuffer

/** Makes the samples of a recorded camera. Waits while all its buffers are in use. */
internal class CameraPlayer(private val camera: RecordedCamera, private val groundTruth: GroundTruth?) {
    private val width = camera.intrinsics.width
    private val height = camera.intrinsics.height
    private val pool = BufferPool(width * height, BUFFERS)
    private val decoder = GreyImageDecoder(width, height)

    fun track(): ReplayTrack = ReplayTrack(LongArray(camera.images.size) { camera.images[it].stampNanos }, ::sample)

    private suspend fun sample(row: Int, captureNanos: Long): ImageSample {
        val image = camera.images[row]
        val pixels = pixels(image.file)
        return ImageSample(
            captureNanos,
            frameNumber = row.toLong(),
            width,
            height,
            strideBytes = width,
            pose = groundTruth?.poseAt(image.stampNanos)?.let { it * camera.inBody },
            camera.intrinsics,
            CaptureMetadata(),
            listOf(ImageSample.Plane(ImageSample.IMAGE, pixels)),
        ) { pool.release(pixels) }
    }

    private suspend fun pixels(file: File): ByteBuffer {
        var buffer: ByteBuffer? = null
        var isDecoded = false
        try {
            return runInterruptible(Dispatchers.IO) {
                pool.acquireBlocking().also {
                    buffer = it
                    decoder.decode(file, it)
                    it.flip()
                }
            }.also { isDecoded = true }
        } finally {
            if (!isDecoded) buffer?.let(pool::release)
        }
    }

    private companion object {
        /** More than a lane queues and sends at once, so that the replay never waits for a receiver that keeps up. */
        const val BUFFERS = 8
    }
}
