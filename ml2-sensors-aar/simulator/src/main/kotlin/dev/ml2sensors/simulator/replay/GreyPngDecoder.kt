package dev.ml2sensors.simulator.replay

import java.awt.image.BufferedImage
import java.awt.image.DataBufferByte
import java.io.EOFException
import java.io.File
import java.io.IOException
import java.nio.ByteBuffer
import javax.imageio.ImageIO
import javax.imageio.ImageReader

/** Decodes 8-bit grey PNG files of one size, one at a time. */
internal class GreyPngDecoder(private val width: Int, private val height: Int) {
    private val reader: ImageReader = ImageIO.getImageReadersByFormatName("png").next()
    private val image = BufferedImage(width, height, BufferedImage.TYPE_BYTE_GRAY)
    private val pixels = (image.raster.dataBuffer as DataBufferByte).data
    private val parameters = reader.defaultReadParam.apply { destination = image }

    /**
     * Writes the pixels of [file], row by row, to [target].
     *
     * @throws RecordingException if it is no such PNG.
     */
    fun decode(file: File, target: ByteBuffer) {
        try {
            ImageIO.createImageInputStream(file).use { input ->
                reader.input = input
                checkFormat(file)
                reader.read(0, parameters)
            }
        } catch (failure: RecordingException) {
            throw failure
        } catch (failure: IOException) {
            throw RecordingException(file, null, "a PNG image", "${failure.message}", failure)
        }
        target.put(pixels)
    }

    private fun checkFormat(file: File) {
        val isGrey = reader.getRawImageType(0)?.bufferedImageType == BufferedImage.TYPE_BYTE_GRAY
        val found = "${reader.getWidth(0)}x${reader.getHeight(0)}, ${if (isGrey) "8-bit grey" else "another pixel format"}"
        val expected = "${width}x$height, 8-bit grey"
        if (found != expected) throw RecordingException(file, null, expected, found)
    }
}
