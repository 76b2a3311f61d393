package dev.ml2sensors.android

import android.media.Image
import java.nio.ByteBuffer

/**
 * Copies YUV_420_888 images of [width] x [height] to NV21, what [android.graphics.YuvImage] encodes: rows of Y without
 * padding, then rows of V and U interleaved. Used by one thread.
 */
internal class Nv21(private val width: Int, private val height: Int) {
    private val chromaWidth = (width + 1) / 2
    private val chromaHeight = (height + 1) / 2
    private var rowOfU = ByteArray(0)
    private var rowOfV = ByteArray(0)
    private val pairs = ByteArray(2 * chromaWidth)

    val sizeBytes: Int = width * height + 2 * chromaWidth * chromaHeight

    /**
     * @param planes Y, U, V with strides of their own; Y has a pixel stride of 1, as Android promises.
     * @param target takes [sizeBytes] from its position on.
     */
    fun copy(planes: Array<Image.Plane>, target: ByteBuffer) {
        val (y, u, v) = planes
        val luma = y.buffer.duplicate()
        for (row in 0 until height) {
            luma.limit(row * y.rowStride + width).position(row * y.rowStride)
            target.put(luma)
        }
        // The last pixel of a row need not be followed by a whole stride
        rowOfU = rowOfU.sized((chromaWidth - 1) * u.pixelStride + 1)
        rowOfV = rowOfV.sized((chromaWidth - 1) * v.pixelStride + 1)
        for (row in 0 until chromaHeight) {
            u.buffer.row(row * u.rowStride).get(rowOfU)
            v.buffer.row(row * v.rowStride).get(rowOfV)
            interleave(u.pixelStride, v.pixelStride)
            target.put(pairs)
        }
    }

    private fun interleave(strideOfU: Int, strideOfV: Int) {
        for (column in 0 until chromaWidth) {
            pairs[2 * column] = rowOfV[column * strideOfV]
            pairs[2 * column + 1] = rowOfU[column * strideOfU]
        }
    }

    private fun ByteBuffer.row(startBytes: Int): ByteBuffer = apply { position(startBytes) }

    private fun ByteArray.sized(bytes: Int) = if (size == bytes) this else ByteArray(bytes)
}
