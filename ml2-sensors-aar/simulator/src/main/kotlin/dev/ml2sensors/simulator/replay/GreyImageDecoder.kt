package dev.ml2sensors.simulator.replay

import java.awt.image.BufferedImage
import java.awt.image.DataBufferByte
import java.awt.image.IndexColorModel
import java.io.File
import java.nio.ByteBuffer
import javax.imageio.ImageIO
import javax.imageio.ImageReader

private const val FORMATS = "PNG or JPEG"
private const val BITS = 8
private const val MAX_VALUE = 255

/**
 * Decodes PNG and JPEG files of one size to 8-bit grey. Of more bits per value it takes the upper eight, and of colours
 * the luma of ITU-R BT.601, as OpenCV does. Thread-safe; calls run one at a time.
 */
internal class GreyImageDecoder(private val width: Int, private val height: Int) {
    private val grey = BufferedImage(width, height, BufferedImage.TYPE_BYTE_GRAY)
    private val pixels = (grey.raster.dataBuffer as DataBufferByte).data

    /**
     * Writes the pixels of [file], row by row, to [target].
     *
     * @throws RecordingException if it is no PNG or JPEG of this size.
     */
    @Synchronized
    fun decode(file: File, target: ByteBuffer) {
        read(file) { reader ->
            if (reader.isGrey8()) {
                reader.read(0, reader.defaultReadParam.apply { destination = grey })
            } else {
                reader.read(0).toGrey(pixels)
            }
        }
        target.put(pixels)
    }

    /**
     * Returns the pixel format of [file] in words, or null for 8-bit grey.
     *
     * @throws RecordingException as [decode], but the pixels are not read.
     */
    fun otherFormat(file: File): String? = read(file) { reader ->
        if (reader.isGrey8()) return@read null
        val model = reader.getImageTypes(0).next().colorModel
        when {
            model is IndexColorModel -> "indexed colour"
            model.numColorComponents == 1 -> "${model.getComponentSize(0)}-bit grey"
            else -> "${model.getComponentSize(0)}-bit colour"
        }
    }

    private fun <T> read(file: File, use: (ImageReader) -> T): T = try {
        ImageIO.createImageInputStream(file).use { input ->
            val reader =
                ImageIO.getImageReaders(input).asSequence().firstOrNull { it.formatName in setOf("png", "JPEG") }
                    ?: throw RecordingException(file, null, "a $FORMATS image", "another format")
            try {
                reader.input = input
                val (foundWidth, foundHeight) = reader.getWidth(0) to reader.getHeight(0)
                if (foundWidth != width || foundHeight != height) {
                    throw RecordingException(file, null, "${width}x$height pixels", "${foundWidth}x$foundHeight")
                }
                use(reader)
            } finally {
                reader.dispose()
            }
        }
    } catch (failure: RecordingException) {
        throw failure
    } catch (failure: Exception) {
        // The JDK's readers throw unchecked exceptions of several kinds for damaged files
        throw RecordingException(file, null, "a $FORMATS image", "$failure", failure)
    }
}

private fun ImageReader.isGrey8() = getRawImageType(0)?.bufferedImageType == BufferedImage.TYPE_BYTE_GRAY

private fun BufferedImage.toGrey(target: ByteArray) {
    val bits = colorModel.getComponentSize(0)
    var values = IntArray(0)
    for (y in 0 until height) {
        if (colorModel is IndexColorModel) {
            for (x in 0 until width) target[y * width + x] = getRGB(x, y).let { luma(it shr 16, it shr 8, it) }
            continue
        }
        values = raster.getPixels(0, y, width, 1, values.takeIf { it.isNotEmpty() })
        val bands = raster.numBands
        for (x in 0 until width) {
            val at = x * bands
            target[y * width + x] = when {
                bands < 3 -> eightBits(values[at], bits).toByte()

                else -> luma(
                    eightBits(values[at], bits),
                    eightBits(values[at + 1], bits),
                    eightBits(values[at + 2], bits),
                )
            }
        }
    }
}

private fun eightBits(value: Int, bits: Int): Int =
    if (bits >= BITS) value shr (bits - BITS) else value * MAX_VALUE / ((1 shl bits) - 1)

/** Only the lower eight bits of each count. ITU-R BT.601, section 2.5.1. */
private fun luma(red: Int, green: Int, blue: Int): Byte {
    val (r, g, b) = Triple(red and MAX_VALUE, green and MAX_VALUE, blue and MAX_VALUE)
    return ((299 * r + 587 * g + 114 * b + 500) / 1000).toByte()
}
