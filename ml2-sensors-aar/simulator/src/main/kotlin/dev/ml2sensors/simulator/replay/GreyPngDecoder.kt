package dev.ml2sensors.simulator.replay

import java.awt.image.BufferedImage
import java.awt.image.DataBufferByte
import java.io.File
import java.nio.ByteBuffer
import javax.imageio.ImageIO
import javax.imageio.ImageReader

/** Decodes 8-bit grey PNG files of one size. Thread-safe; calls run one at a time. */
internal class GreyPngDecoder(width: Int, height: Int) {
    private val expected = "${width}x$height, 8-bit grey"
    private val reader: ImageReader = ImageIO.getImageReadersByFormatName("png").next()
    private val image = BufferedImage(width, height, BufferedImage.TYPE_BYTE_GRAY)
    private val pixels = (image.raster.dataBuffer as DataBufferByte).data
    private val parameters = reader.defaultReadParam.apply { destination = image }

    /**
     * Writes the pixels of [file], row by row, to [target].
     *
     * @throws RecordingException if it is not an 8-bit grey PNG of this size.
     */
    @Synchronized
    fun decode(file: File, target: ByteBuffer) {
        val found = read(file)
        if (found != expected) throw RecordingException(file, null, expected, found)
        target.put(pixels)
    }

    /** Returns the size and pixel format of [file]. If they are as expected, decodes it into [image]. */
    private fun read(file: File): String = try {
        ImageIO.createImageInputStream(file).use { input ->
            reader.input = input
            format().also { if (it == expected) reader.read(0, parameters) }
        }
    } catch (failure: Exception) {
        // The JDK's reader throws unchecked exceptions of several kinds for damaged files
        throw RecordingException(file, null, "a PNG image", "$failure", failure)
    }

    private fun format(): String {
        val isGrey = reader.getRawImageType(0)?.bufferedImageType == BufferedImage.TYPE_BYTE_GRAY
        return "${reader.getWidth(0)}x${reader.getHeight(0)}, ${if (isGrey) "8-bit grey" else "another pixel format"}"
    }
}
