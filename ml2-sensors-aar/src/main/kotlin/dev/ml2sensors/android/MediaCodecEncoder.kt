package dev.ml2sensors.android

import android.media.MediaCodec
import android.media.MediaFormat
import android.os.Bundle
import android.os.Handler
import android.os.HandlerThread
import android.os.Process
import android.util.Log
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoPacket
import dev.ml2sensors.source.YuvPlane
import dev.ml2sensors.source.YuvPlanes
import dev.ml2sensors.source.hasParameterSets
import dev.ml2sensors.source.isKeyFrame
import java.nio.ByteBuffer
import java.util.concurrent.ConcurrentLinkedQueue

/**
 * Android's encoder [name], asynchronous, with a thread of its own for what it makes.
 *
 * Nothing of it is left when its constructor throws.
 *
 * @throws java.io.IOException if it does not open.
 * @throws RuntimeException of any kind if it does not take [format].
 */
internal class MediaCodecEncoder(
    private val name: String,
    format: MediaFormat,
    private val output: VideoOutput,
    private val calls: PlatformCalls,
) : VideoEncoder {
    private val planes =
        YuvPlanes(format.getInteger(MediaFormat.KEY_WIDTH), format.getInteger(MediaFormat.KEY_HEIGHT))
    private val codec = MediaCodec.createByCodecName(name)
    private val thread = HandlerThread("ml2s-video", Process.THREAD_PRIORITY_DISPLAY).apply { start() }
    private val handler = Handler(thread.looper)
    private val freeInputs = ConcurrentLinkedQueue<Int>()

    init {
        try {
            codec.setCallback(Callback(), handler)
            codec.configure(format, null, null, MediaCodec.CONFIGURE_FLAG_ENCODE)
            codec.start()
        } catch (e: Throwable) {
            close()
            throw e
        }
    }

    override fun encode(image: ImageSample, presentationMicros: Long, asKeyFrame: Boolean): Boolean {
        val index = freeInputs.poll() ?: return false
        try {
            // Before its image, which this would make invalid
            val sizeBytes = checkNotNull(codec.getInputBuffer(index)).capacity()
            val input = codec.getInputImage(index) ?: throw SourceException("Android's encoder $name shows no planes")
            val (y, u, v) = input.planes.map { YuvPlane(it.buffer, it.rowStride, it.pixelStride) }
            planes.copy(image, y, u, v)
            if (asKeyFrame) codec.setParameters(KEY_FRAME)
            codec.queueInputBuffer(index, 0, sizeBytes, presentationMicros, 0)
        } catch (e: RuntimeException) {
            throw failure(e)
        }
        return true
    }

    private fun failure(e: RuntimeException) = SourceException("Android's encoder $name failed: ${e.message}", e)

    /**
     * Ends on the encoder's own thread, so that no callback meets a codec that was released. An encoder that is not
     * released in time is left behind; until it is, no other is opened.
     */
    override fun close() {
        try {
            calls.end("Android's encoder $name") {
                handler.post(::release)
                thread.quitSafely()
                thread.join()
            }
        } catch (_: NoAnswerException) {
            // The next opening says so
        }
    }

    private fun release() = try {
        codec.release()
    } catch (e: RuntimeException) { // One that leaves this thread would end the app
        Log.w("ml2s", "Android's encoder $name is not released: ${e.message}")
    }

    private inner class Callback : MediaCodec.Callback() {
        /** For encoders that do not put them before key frames. */
        private var parameterSets = ByteArray(0)

        override fun onInputBufferAvailable(codec: MediaCodec, index: Int) {
            freeInputs += index
        }

        override fun onOutputBufferAvailable(codec: MediaCodec, index: Int, info: MediaCodec.BufferInfo): Unit = try {
            codec.getOutputBuffer(index)?.let { bytes ->
                bytes.limit(info.offset + info.size).position(info.offset)
                take(bytes, info)
            }
            codec.releaseOutputBuffer(index, false)
        } catch (e: RuntimeException) { // One that leaves a callback would end the app
            output.failed(failure(e))
        }

        private fun take(bytes: ByteBuffer, info: MediaCodec.BufferInfo) {
            if (info.flags and MediaCodec.BUFFER_FLAG_CODEC_CONFIG != 0) {
                parameterSets = ByteArray(bytes.remaining()).also(bytes::get)
            } else if (info.size > 0) {
                output.packet(VideoPacket(info.presentationTimeUs, whole(bytes)))
            }
        }

        private fun whole(bytes: ByteBuffer): ByteBuffer {
            val isWhole = !bytes.isKeyFrame() || bytes.hasParameterSets()
            if (isWhole) return bytes
            return ByteBuffer.allocate(parameterSets.size + bytes.remaining()).put(parameterSets).put(bytes).flip()
        }

        override fun onError(codec: MediaCodec, e: MediaCodec.CodecException): Unit = output.failed(failure(e))

        override fun onOutputFormatChanged(codec: MediaCodec, format: MediaFormat): Unit = Unit
    }

    private companion object {
        val KEY_FRAME = Bundle().apply { putInt(MediaCodec.PARAMETER_KEY_REQUEST_SYNC_FRAME, 0) }
    }
}
