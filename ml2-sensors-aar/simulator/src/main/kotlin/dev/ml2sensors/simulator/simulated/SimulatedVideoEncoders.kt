package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoEncoders
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoPacket
import dev.ml2sensors.source.VideoSettings
import dev.ml2sensors.source.YuvPlane
import dev.ml2sensors.source.YuvPlanes
import java.nio.ByteBuffer
import java.util.concurrent.ArrayBlockingQueue
import java.util.concurrent.Executors
import java.util.concurrent.TimeUnit

/** Simulates the video encoders of Android with [OpenH264]. [NativeBundle] must have been loaded. */
internal object SimulatedVideoEncoders : VideoEncoders() {
    override fun refusal(settings: VideoSettings): String? = OpenH264.refusal()

    override fun open(settings: VideoSettings, output: VideoOutput): VideoEncoder =
        SimulatedVideoEncoder(settings, output)
}

/** Encodes on a thread of its own, from [INPUTS] buffers whose rows are padded, as those of an encoder chip are. */
private class SimulatedVideoEncoder(private val settings: VideoSettings, private val output: VideoOutput) :
    VideoEncoder {
    private val strideBytes = (settings.width + ROW_BYTES - 1) / ROW_BYTES * ROW_BYTES
    private val planes = YuvPlanes(settings.width, settings.height)

    /** Brightness, then pairs of V and U (NV21). */
    private inner class Input {
        val luma: ByteBuffer = ByteBuffer.allocateDirect(strideBytes * settings.height)
        val chroma: ByteBuffer = ByteBuffer.allocateDirect(strideBytes * ((settings.height + 1) / 2))
        private val y = YuvPlane(luma, strideBytes, pixelStride = 1)
        private val u = YuvPlane(chroma.duplicate().position(1).slice(), strideBytes, pixelStride = 2)
        private val v = YuvPlane(chroma, strideBytes, pixelStride = 2)

        fun put(image: ImageSample): Unit = planes.copy(image, y, u, v)
    }

    private val inputs = ArrayBlockingQueue<Input>(INPUTS)
    private val encoded = ByteBuffer.allocateDirect(settings.width * settings.height)
    private val thread = Executors.newSingleThreadExecutor { Thread(it, "openh264") }
    private val encoder = with(settings) { OpenH264.open(width, height, rateHz, bitsPerSecond) }

    init {
        if (encoder == 0L) throw SourceException("openh264 does not take $settings")
        repeat(INPUTS) { inputs.add(Input()) }
    }

    override fun encode(image: ImageSample, presentationMicros: Long, asKeyFrame: Boolean): Boolean {
        val input = inputs.poll() ?: return false
        input.put(image)
        thread.execute { encode(input, presentationMicros, asKeyFrame) }
        return true
    }

    private fun encode(input: Input, presentationMicros: Long, asKeyFrame: Boolean) {
        val size = with(input) {
            OpenH264.encode(encoder, luma, chroma, strideBytes, presentationMicros, asKeyFrame, encoded)
        }
        inputs.add(input)
        if (size < 0) {
            output.failed(SourceException("openh264 does not encode an image of $settings"))
        } else if (size > 0) {
            output.packet(VideoPacket(presentationMicros, encoded.duplicate().limit(size)))
        }
    }

    override fun close() {
        thread.shutdown()
        check(thread.awaitTermination(LIMIT_S, TimeUnit.SECONDS)) { "openh264 does not end" }
        OpenH264.close(encoder)
    }

    private companion object {
        const val INPUTS = 2
        const val ROW_BYTES = 64
        const val LIMIT_S = 10L
    }
}
