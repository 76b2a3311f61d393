package dev.ml2sensors.simulator.replay

import java.io.ByteArrayOutputStream
import java.io.DataInputStream
import java.io.File
import java.util.zip.InflaterInputStream
import kotlin.math.abs

/** The pixels of an 8-bit grey PNG without interlacing, straight from the specification (chunks, section 9 filters). */
internal fun greyPixels(file: File): ByteArray {
    val data = ByteArrayOutputStream()
    var width = 0
    var height = 0
    DataInputStream(file.inputStream().buffered()).use { input ->
        input.skipNBytes(8)
        do {
            val chunk = ByteArray(input.readInt())
            val type = String(input.readNBytes(4))
            input.readFully(chunk)
            input.readInt()
            val fields = DataInputStream(chunk.inputStream())
            if (type == "IHDR") {
                width = fields.readInt()
                height = fields.readInt()
                check(fields.readNBytes(5).toList() == listOf<Byte>(8, 0, 0, 0, 0)) { "not 8-bit grey" }
            }
            if (type == "IDAT") data.write(chunk)
        } while (type != "IEND")
    }
    val rows = InflaterInputStream(data.toByteArray().inputStream()).use { it.readAllBytes() }
    check(rows.size == height * (width + 1)) { "${rows.size} bytes" }
    return unfilter(rows, width, height)
}

private fun unfilter(rows: ByteArray, width: Int, height: Int): ByteArray {
    val pixels = ByteArray(width * height)
    for (y in 0 until height) {
        for (x in 0 until width) {
            val left = if (x > 0) pixels[y * width + x - 1].toInt() and 255 else 0
            val up = if (y > 0) pixels[(y - 1) * width + x].toInt() and 255 else 0
            val corner = if (x > 0 && y > 0) pixels[(y - 1) * width + x - 1].toInt() and 255 else 0
            val predicted = when (val filter = rows[y * (width + 1)].toInt()) {
                0 -> 0
                1 -> left
                2 -> up
                3 -> (left + up) / 2
                4 -> listOf(left, up, corner).minBy { abs(left + up - corner - it) }
                else -> error("filter $filter")
            }
            pixels[y * width + x] = (rows[y * (width + 1) + 1 + x] + predicted).toByte()
        }
    }
    return pixels
}
