package dev.ml2sensors.android

import android.graphics.ImageFormat
import android.media.Image
import android.media.MediaCodec
import android.media.MediaCodecInfo.CodecCapabilities
import android.media.MediaCodecInfo.CodecProfileLevel
import android.media.MediaFormat
import android.os.Bundle
import android.view.Surface
import dev.ml2sensors.simulator.simulated.OpenH264
import dev.ml2sensors.source.hasParameterSets
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import org.robolectric.annotation.RealObject
import org.robolectric.shadows.MediaCodecInfoBuilder
import org.robolectric.shadows.MediaCodecInfoBuilder.CodecCapabilitiesBuilder
import org.robolectric.shadows.ShadowMediaCodec
import org.robolectric.shadows.ShadowMediaCodecList
import org.robolectric.util.ReflectionHelpers
import org.robolectric.util.ReflectionHelpers.ClassParameter
import java.nio.ByteBuffer
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.ConcurrentLinkedQueue

/** An encoder below Android's own MediaCodec, of which openh264 does the work. */
@Implements(MediaCodec::class)
class AvcCodec : ShadowMediaCodec() {
    @RealObject
    private lateinit var codec: MediaCodec

    @Implementation
    @Suppress("ktlint:standard:function-naming")
    override fun __constructor__(name: String, isType: Boolean, isEncoder: Boolean) {
        pass("createByCodecName")
        super.__constructor__(name, isType, isEncoder)
    }

    @Implementation
    override fun native_start() {
        pass("start")
        super.native_start()
    }

    @Implementation
    override fun getBuffer(isInput: Boolean, index: Int): ByteBuffer? {
        pass(if (isInput) "getInputBuffer" else "getOutputBuffer")
        return super.getBuffer(isInput, index)
    }

    @Implementation
    override fun releaseOutputBuffer(index: Int, isRendered: Boolean) {
        pass("releaseOutputBuffer")
        super.releaseOutputBuffer(index, isRendered)
    }

    @Implementation
    fun getInputImage(index: Int): Image {
        pass("getInputImage")
        val memory = checkNotNull(codec.getInputBuffer(index))
        val planes = layout.planes(memory, size.first, size.second)
        return FakeImage(ImageFormat.YUV_420_888, size.first, size.second, 0, planes)
    }

    @Implementation
    fun setParameters(parameters: Bundle) {
        pass("setParameters")
        if (parameters.containsKey(MediaCodec.PARAMETER_KEY_REQUEST_SYNC_FRAME)) isKeyFrameWanted = true
    }

    @Implementation
    override fun native_queueInputBuffer(index: Int, offset: Int, size: Int, micros: Long, flags: Int) {
        pass("queueInputBuffer")
        val isConfig = sendsParameterSetsOnce && parameterSets == null
        val added = if (isConfig) MediaCodec.BUFFER_FLAG_CODEC_CONFIG else 0
        super.native_queueInputBuffer(index, offset, size, micros, flags or added)
    }

    @Implementation
    override fun native_setCallback(callback: MediaCodec.Callback?) {
        pass("setCallback")
        AvcCodec.callback = callback
        super.native_setCallback(callback)
    }

    @Implementation
    @Suppress("ktlint:standard:function-naming")
    fun native_release(): Unit = pass("release")

    /** Reports an error of the chip, on this thread. */
    fun fail(): Unit = checkNotNull(callback).onError(codec, codecException("the chip is gone"))

    /** The layout of an input's planes in memory. Chroma begins after a brightness whose rows are padded. */
    enum class Layout(private val chromaStep: Int, private val offsetOfU: Int, private val offsetOfV: Int) {
        /** Pairs of U and V. */
        NV12(2, 0, 1),

        /** Pairs of V and U. */
        NV21(2, 1, 0),
        ;

        fun stride(width: Int) = (width + 63) / 64 * 64

        internal fun planes(memory: ByteBuffer, width: Int, height: Int): List<FakePlane> {
            val stride = stride(width)
            fun plane(offset: Int, size: Int, step: Int) =
                FakePlane(memory.duplicate().position(offset).limit(offset + size).slice(), stride, step)
            val chroma = stride * height
            val chromaSize = (height / 2 - 1) * stride + width - 1
            return listOf(
                plane(0, (height - 1) * stride + width, 1),
                plane(chroma + offsetOfU, chromaSize, chromaStep),
                plane(chroma + offsetOfV, chromaSize, chromaStep),
            )
        }
    }

    companion object {
        const val NAME = "OMX.test.avc.encoder"
        var layout = Layout.NV12

        /** As an encoder lists them. */
        var bitRateModes = "VBR,CBR"

        /** True if parameter sets come once, in a buffer of their own, and not before key frames. */
        var sendsParameterSetsOnce = false

        /** The exceptions that its calls throw, by the names of the calls. */
        val failures = ConcurrentHashMap<String, Exception>()

        /** The images that it was given, without padding: brightness, then U, then V. */
        val inputs = ConcurrentLinkedQueue<ByteArray>()

        /** The format it was configured with. */
        lateinit var format: MediaFormat
            private set
        private var callback: MediaCodec.Callback? = null
        private var size = 0 to 0
        private var isKeyFrameWanted = false
        private var parameterSets: ByteArray? = null
        private var encoder = 0L
        private var micros = 0L
        private val loaded by lazy { loadCopy("host/sim/jni/libml2sim_openh264.so") }

        /** Adds it to the encoders that Android lists, for images up to [width] x [height]. */
        fun install(width: Int, height: Int, colorFormat: Int = CodecCapabilities.COLOR_FormatYUV420Flexible) {
            loaded
            val formats = MediaFormat.createVideoFormat(MediaFormat.MIMETYPE_VIDEO_AVC, width, height)
            formats.setString("feature-bitrate-modes", bitRateModes)
            val level = CodecProfileLevel().apply {
                profile = CodecProfileLevel.AVCProfileBaseline
                this.level = CodecProfileLevel.AVCLevel51
            }
            val abilities = CodecCapabilitiesBuilder.newBuilder().setMediaFormat(formats).setIsEncoder(true)
                .setProfileLevels(arrayOf(level)).setColorFormats(intArrayOf(colorFormat)).build()
            ShadowMediaCodecList.addCodec(
                MediaCodecInfoBuilder.newBuilder().setName(NAME).setIsEncoder(true).setIsHardwareAccelerated(true)
                    .setCapabilities(abilities).build(),
            )
            val config = CodecConfig(2 * width * height, 4 * width * height, Work)
            addDecoder(NAME, config) // Android asks for it by name alone
            addEncoder(NAME, config)
        }

        /** Stands where Android's own carries out [call]. */
        private fun pass(call: String) {
            NeverReturns.pass("MediaCodec.$call")
            failures[call]?.let { throw it }
        }

        /** Returns an exception of MediaCodec itself. */
        fun codecException(message: String): MediaCodec.CodecException = ReflectionHelpers.callConstructor(
            MediaCodec.CodecException::class.java,
            ClassParameter.from(Int::class.java, 1),
            ClassParameter.from(Int::class.java, 0),
            ClassParameter.from(String::class.java, message),
        )

        fun reset() {
            layout = Layout.NV12
            bitRateModes = "VBR,CBR"
            sendsParameterSetsOnce = false
            failures.clear()
            inputs.clear()
            isKeyFrameWanted = false
            parameterSets = null
            micros = 0
            Work.replace(0)
            clearCodecs()
            ShadowMediaCodecList.reset()
        }
    }

    private object Work : CodecConfig.Codec {
        override fun onConfigured(
            format: MediaFormat,
            surface: Surface?,
            crypto: android.media.MediaCrypto?,
            flags: Int,
        ) {
            pass("configure")
            Companion.format = format
            size = format.getInteger(MediaFormat.KEY_WIDTH) to format.getInteger(MediaFormat.KEY_HEIGHT)
            val rateHz = format.getInteger(MediaFormat.KEY_FRAME_RATE)
            replace(OpenH264.open(size.first, size.second, rateHz, format.getInteger(MediaFormat.KEY_BIT_RATE)))
            check(encoder != 0L)
        }

        @Synchronized
        fun replace(next: Long) {
            if (encoder != 0L) OpenH264.close(encoder)
            encoder = next
        }

        /** A call that did not return may use the encoder while it is replaced. */
        @Synchronized
        override fun process(input: ByteBuffer, output: ByteBuffer) {
            val (width, height) = size
            val stride = layout.stride(width)
            val planes = layout.planes(input, width, height)
            inputs += planes.flatMapIndexed { index, plane ->
                val step = if (index == 0) 1 else 2
                List(width / step * (height / step)) { at ->
                    val (row, column) = at / (width / step) to at % (width / step)
                    plane.buffer[row * plane.rowStride + column * plane.pixelStride]
                }
            }.toByteArray()
            // openh264 takes pairs of V and U
            val pairs = ByteBuffer.allocateDirect(stride * height / 2)
            for (row in 0 until height / 2) {
                for (column in 0 until width / 2) {
                    val at = row * stride + 2 * column
                    pairs.put(at, planes[2].buffer[at]).put(at + 1, planes[1].buffer[at])
                }
            }
            val brightness = ByteBuffer.allocateDirect(stride * height)
            brightness.put(input.duplicate().position(0).limit(stride * height) as ByteBuffer)
            micros += 33_333
            val bytes = ByteBuffer.allocateDirect(output.capacity())
            val count = OpenH264.encode(
                encoder,
                brightness,
                pairs,
                stride,
                micros,
                isKeyFrameWanted,
                bytes,
            )
            check(count > 0) { "openh264 returns $count" }
            isKeyFrameWanted = false
            output.put(sent(bytes.limit(count) as ByteBuffer))
        }

        /** Returns what is sent of an access unit by [sendsParameterSetsOnce]. */
        private fun sent(unit: ByteBuffer): ByteBuffer {
            if (!sendsParameterSetsOnce || !unit.hasParameterSets()) return unit
            val bytes = ByteArray(unit.remaining()).also { unit.duplicate().get(it) }
            val image = (0..bytes.size - 5).first {
                bytes.slice(it..it + 3) == listOf<Byte>(0, 0, 0, 1) && bytes[it + 4].toInt() and 0x1f == 5
            }
            val isFirst = parameterSets == null
            if (isFirst) parameterSets = bytes.copyOf(image)
            return ByteBuffer.wrap(if (isFirst) bytes.copyOf(image) else bytes.copyOfRange(image, bytes.size))
        }
    }
}
