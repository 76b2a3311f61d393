package dev.ml2sensors.android

import android.media.MediaCodecInfo
import android.media.MediaCodecInfo.CodecCapabilities
import android.media.MediaCodecInfo.EncoderCapabilities
import android.media.MediaCodecList
import android.media.MediaFormat
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoEncoders
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoSettings
import java.io.IOException

/** The H.264 encoders that Android lists; those in hardware first. The bit rate is constant where the encoder can do that. */
internal class MediaCodecEncoders(private val calls: PlatformCalls = PlatformCalls()) : VideoEncoders() {
    override fun refusal(settings: VideoSettings): String? {
        if (encoder(settings) != null) return null
        val names = encoders().joinToString { it.name }.ifEmpty { "none" }
        return "no encoder for h264 takes ${settings.inWords()}; this headset has: $names"
    }

    override fun open(settings: VideoSettings, output: VideoOutput): VideoEncoder {
        val info = calls.call("Android's list of encoders") {
            encoder(settings) ?: throw SourceException(refusal(settings).orEmpty())
        }
        return try {
            calls.call("Android's encoder ${info.name}", late = VideoEncoder::close) {
                MediaCodecEncoder(info.name, info.abilities.formatOf(settings), output, calls)
            }
        } catch (e: SourceException) {
            throw e
        } catch (e: IOException) {
            throw SourceException("Android's encoder ${info.name} does not open: ${e.message}", e)
        } catch (e: RuntimeException) { // Codecs throw more kinds than are documented
            throw SourceException("Android's encoder ${info.name} does not take ${settings.inWords()}: ${e.message}", e)
        }
    }

    private fun encoder(settings: VideoSettings): MediaCodecInfo? = encoders().firstOrNull {
        val takesPixels = CodecCapabilities.COLOR_FormatYUV420Flexible in it.abilities.colorFormats
        takesPixels && it.abilities.isFormatSupported(it.abilities.formatOf(settings))
    }

    private val MediaCodecInfo.abilities: CodecCapabilities get() = getCapabilitiesForType(MIME)

    private fun encoders() = MediaCodecList(MediaCodecList.REGULAR_CODECS).codecInfos
        .filter { it.isEncoder && MIME in it.supportedTypes }
        .sortedByDescending { it.isHardwareAccelerated }

    private fun VideoSettings.inWords() = "${width}x$height at $rateHz Hz and ${bitsPerSecond / 1_000_000} Mbit/s"

    private fun CodecCapabilities.formatOf(settings: VideoSettings) =
        MediaFormat.createVideoFormat(MIME, settings.width, settings.height).apply {
            setInteger(MediaFormat.KEY_COLOR_FORMAT, CodecCapabilities.COLOR_FormatYUV420Flexible)
            setInteger(MediaFormat.KEY_FRAME_RATE, settings.rateHz)
            setInteger(MediaFormat.KEY_BIT_RATE, settings.bitsPerSecond)
            val isConstant = encoderCapabilities.isBitrateModeSupported(EncoderCapabilities.BITRATE_MODE_CBR)
            if (isConstant) setInteger(MediaFormat.KEY_BITRATE_MODE, EncoderCapabilities.BITRATE_MODE_CBR)
            // Key frames are asked for
            setInteger(MediaFormat.KEY_I_FRAME_INTERVAL, SELDOM_S)
            setInteger(MediaFormat.KEY_MAX_B_FRAMES, 0)
            setInteger(MediaFormat.KEY_LATENCY, 1)
            setInteger(MediaFormat.KEY_PRIORITY, REAL_TIME)
            setInteger(MediaFormat.KEY_PREPEND_HEADER_TO_SYNC_FRAMES, 1)
            setInteger(MediaFormat.KEY_COLOR_RANGE, MediaFormat.COLOR_RANGE_FULL)
            setInteger(MediaFormat.KEY_COLOR_STANDARD, MediaFormat.COLOR_STANDARD_BT601_PAL)
            setInteger(MediaFormat.KEY_COLOR_TRANSFER, MediaFormat.COLOR_TRANSFER_SDR_VIDEO)
        }

    private companion object {
        const val MIME = MediaFormat.MIMETYPE_VIDEO_AVC
        const val SELDOM_S = 3600
        const val REAL_TIME = 0
    }
}
