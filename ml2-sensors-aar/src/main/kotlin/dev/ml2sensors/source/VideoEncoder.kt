package dev.ml2sensors.source

import java.nio.ByteBuffer

/** The settings of a video in H.264: [rateHz] images per second of [width] x [height] pixels, [bitsPerSecond]. */
internal data class VideoSettings(val width: Int, val height: Int, val rateHz: Int, val bitsPerSecond: Int)

/**
 * One image as H.264: an access unit of the byte stream format (ITU-T H.264, Annex B). Parameter sets are before each
 * key frame.
 *
 * @property presentationMicros as given to [VideoEncoder.encode].
 * @property bytes from position to limit, valid until [VideoOutput.packet] returns.
 */
internal class VideoPacket(val presentationMicros: Long, val bytes: ByteBuffer)

/** Takes the packets of an encoder. One thread at a time calls it, which may be the encoder's own. */
internal interface VideoOutput {
    /** Takes the next image, in order of presentation. An encoder may skip images. */
    fun packet(packet: VideoPacket)

    /** The encoder has failed, and makes nothing more. */
    fun failed(cause: Exception)
}

/**
 * Encodes the images of one stream, each of which depends on those before it but for key frames. The first one is a key
 * frame. [encode] and [close] are called by one thread at a time.
 */
internal interface VideoEncoder : AutoCloseable {
    /**
     * Copies the pixels of [image], grey or with [ImageSample.CHROMA], to be encoded soon. Returns false if the encoder
     * has no room for it at present.
     *
     * @param presentationMicros later than that of the image before.
     * @param asKeyFrame true if the image must not depend on others.
     */
    fun encode(image: ImageSample, presentationMicros: Long, asKeyFrame: Boolean): Boolean

    /** Ends the encoder; images that are being encoded may get lost. */
    override fun close()
}

/** The video encoders of a platform, which the library uses for a headset that has them. Thread-safe. */
public abstract class VideoEncoders internal constructor() {
    /** Returns why no encoder makes such video, null if one does. */
    internal abstract fun refusal(settings: VideoSettings): String?

    /**
     * Opens an encoder.
     *
     * @throws SourceException if there is none, or it fails.
     */
    internal abstract fun open(settings: VideoSettings, output: VideoOutput): VideoEncoder
}

/** Returns true if the access unit in this buffer, from position to limit, is a key frame. */
internal fun ByteBuffer.isKeyFrame(): Boolean = nalTypes().any { it == NAL_IDR }

/** Returns true if the access unit in this buffer, from position to limit, has parameter sets before its image. */
internal fun ByteBuffer.hasParameterSets(): Boolean = nalTypes().any { it == NAL_SEQUENCE_PARAMETERS }

/** Returns the types of the units in this byte stream, up to the first one of an image. */
private fun ByteBuffer.nalTypes(): Sequence<Int> = sequence {
    for (at in position() until limit() - START_CODE.size) {
        if (!START_CODE.indices.all { get(at + it) == START_CODE[it] }) continue
        val type = get(at + START_CODE.size).toInt() and NAL_TYPE_BITS
        yield(type)
        if (type in NAL_SLICES) return@sequence
    }
}

private val START_CODE = byteArrayOf(0, 0, 1)

// ITU-T H.264, table 7-1
private const val NAL_TYPE_BITS = 0x1f
private const val NAL_IDR = 5
private const val NAL_SEQUENCE_PARAMETERS = 7
private val NAL_SLICES = 1..5
