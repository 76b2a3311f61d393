package dev.ml2sensors.source

import java.nio.ByteBuffer

/** One plane of pixels: rows of [rowStride] bytes, values [pixelStride] bytes apart, the first one at index 0. */
internal class YuvPlane(val bytes: ByteBuffer, val rowStride: Int, val pixelStride: Int) {
    /** Copies [count] bytes of [source], from [offset] on, into the row [row]. */
    fun putRow(row: Int, source: ByteBuffer, offset: Int, count: Int) {
        val from = source.duplicate()
        from.limit(offset + count).position(offset)
        bytes.duplicate().position(row * rowStride).put(from)
    }

    fun putRow(row: Int, source: ByteArray, count: Int) {
        bytes.duplicate().position(row * rowStride).put(source, 0, count)
    }

    fun put(row: Int, column: Int, value: Byte) {
        bytes.put(row * rowStride + column * pixelStride, value)
    }
}

/**
 * Copies raw images of [width] x [height] into the planes of an encoder, 4:2:0 in whatever layout it has. Used by one
 * thread.
 */
internal class YuvPlanes(private val width: Int, private val height: Int) {
    private val chromaWidth = (width + 1) / 2
    private val chromaHeight = (height + 1) / 2

    /** A row of chroma, V first as in the sample. */
    private val row = ByteArray(2 * chromaWidth)
    private val swapped = ByteArray(2 * chromaWidth)
    private val ofU = ByteArray(chromaWidth)
    private val ofV = ByteArray(chromaWidth)

    /** Copies [image] to [y], whose pixelStride is 1, and [u] and [v]. */
    fun copy(image: ImageSample, y: YuvPlane, u: YuvPlane, v: YuvPlane) {
        val luma = image.pixels
        for (row in 0 until height) y.putRow(row, luma, luma.position() + row * image.strideBytes, width)
        val chroma = image.plane(ImageSample.CHROMA)
        if (chroma == null) row.fill(NO_COLOR)
        val put = when {
            u.pixelStride == 1 && v.pixelStride == 1 -> ::putPlanar
            areInterleaved(u, v) -> ::putUFirst
            areInterleaved(v, u) -> ::putVFirst
            else -> ::putSingly
        }
        for (row in 0 until chromaHeight) {
            chroma?.duplicate()?.position(chroma.position() + row * this.row.size)?.get(this.row)
            put(row, u, v)
        }
    }

    private fun putPlanar(at: Int, u: YuvPlane, v: YuvPlane) {
        for (column in 0 until chromaWidth) {
            ofV[column] = row[2 * column]
            ofU[column] = row[2 * column + 1]
        }
        u.putRow(at, ofU, chromaWidth)
        v.putRow(at, ofV, chromaWidth)
    }

    private fun putUFirst(at: Int, u: YuvPlane, v: YuvPlane) {
        for (column in 0 until chromaWidth) {
            swapped[2 * column] = row[2 * column + 1]
            swapped[2 * column + 1] = row[2 * column]
        }
        putPairs(at, swapped, u, v)
    }

    private fun putVFirst(at: Int, u: YuvPlane, v: YuvPlane): Unit = putPairs(at, row, v, u)

    /** The memory of [first] ends before the last value of [second]. */
    private fun putPairs(at: Int, pairs: ByteArray, first: YuvPlane, second: YuvPlane) {
        first.putRow(at, pairs, pairs.size - 1)
        second.put(at, chromaWidth - 1, pairs.last())
    }

    private fun putSingly(at: Int, u: YuvPlane, v: YuvPlane) {
        for (column in 0 until chromaWidth) {
            v.put(at, column, row[2 * column])
            u.put(at, column, row[2 * column + 1])
        }
    }

    /** Tries whether the values of [second] lie right after those of [first], which no buffer tells. */
    private fun areInterleaved(first: YuvPlane, second: YuvPlane): Boolean {
        if (first.pixelStride != 2 || second.pixelStride != 2 || first.rowStride != second.rowStride) return false
        if (first.bytes.limit() < 2) return false
        val before = first.bytes[1]
        val areSame = listOf<Byte>(1, 2).all {
            first.bytes.put(1, it)
            second.bytes[0] == it
        }
        first.bytes.put(1, before)
        return areSame
    }

    private companion object {
        const val NO_COLOR = 128.toByte()
    }
}
