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

    val sizeBytes: Int = width * height + 2 * chromaWidth * chromaHeight

    /** @param planes Y, U, V with strides of their own; Y has a pixel stride of 1, as Android promises. */
    fun copy(planes: Array<Image.Plane>, target: ByteArray) {
        val (y, u, v) = planes
        val luma = y.buffer
        for (row in 0 until height) luma.row(row * y.rowStride).get(target, row * width, width)
        // The last pixel of a row need not be followed by a whole stride
        rowOfU = rowOfU.sized((chromaWidth - 1) * u.pixelStride + 1)
        rowOfV = rowOfV.sized((chromaWidth - 1) * v.pixelStride + 1)
        for (row in 0 until chromaHeight) {
            u.buffer.row(row * u.rowStride).get(rowOfU)
            v.buffer.row(row * v.rowStride).get(rowOfV)
            interleave(u.pixelStride, v.pixelStride, target, width * height + 2 * chromaWidth * row)
        }
    }

    private fun interleave(strideOfU: Int, strideOfV: Int, target: ByteArray, start: Int) {
        for (column in 0 until chromaWidth) {
            target[start + 2 * column] = rowOfV[column * strideOfV]
            target[start + 2 * column + 1] = rowOfU[column * strideOfU]
        }
    }

    private fun ByteBuffer.row(startBytes: Int): ByteBuffer = apply { position(startBytes) }

    private fun ByteArray.sized(bytes: Int) = if (size == bytes) this else ByteArray(bytes)
}
