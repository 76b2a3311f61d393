package dev.ml2sensors.simulator.testsignal

import java.nio.ByteBuffer

/**
 * Writes the frame number into a test image, so that a receiver can verify which frame it got.
 *
 * Raw images: pixels 0 to 31 of row 0 are the bits of the number modulo 2^32, most significant first. A pixel is 0, or
 * for a set bit the value named below, little endian.
 *
 * JPEG: bytes 20 to 39, right after SOI and the APP0 segment of JFIF, are a COM segment: `FF FE 00 12`
 * and the 16 ASCII bytes `frame=0000000042`, the number modulo 10^10 in ten decimal digits.
 */
internal enum class FrameNumber {
    /** 8 bits per pixel, set: 255. */
    MONO8 {
        override fun write(image: ByteBuffer, number: Long) =
            forEachBit(number) { pixel, bit -> image.put(pixel, if (bit) -1 else 0) }
    },

    /** IEEE 754 single, set: 1.0. */
    FLOAT32 {
        override fun write(image: ByteBuffer, number: Long) =
            forEachBit(number) { pixel, bit -> image.putFloat(pixel * Float.SIZE_BYTES, if (bit) 1f else 0f) }
    },

    /** Signed 32-bit integer, set: 1. */
    INT32 {
        override fun write(image: ByteBuffer, number: Long) =
            forEachBit(number) { pixel, bit -> image.putInt(pixel * Int.SIZE_BYTES, if (bit) 1 else 0) }
    },

    /** A JPEG with the comment that [withComment] inserts. */
    JPEG {
        override fun write(image: ByteBuffer, number: Long) {
            var rest = number
            for (index in DIGITS.reversed()) {
                image.put(index, ('0'.code + rest % 10).toByte())
                rest /= 10
            }
        }
    }, ;

    /** Writes [number] into the little-endian [image] that begins at index 0. */
    abstract fun write(image: ByteBuffer, number: Long)

    companion object {
        /** The size of SOI and of an APP0 without a thumbnail. */
        private const val HEAD_BYTES = 2 + 18
        private val COMMENT = byteArrayOf(-1, -2, 0, 18) + "frame=0000000000".toByteArray(Charsets.US_ASCII)
        private val DIGITS = HEAD_BYTES + COMMENT.size - 10 until HEAD_BYTES + COMMENT.size

        /** Returns the JFIF image [jpeg] with the comment that [JPEG] writes to. */
        fun withComment(jpeg: ByteArray): ByteArray =
            jpeg.copyOfRange(0, HEAD_BYTES) + COMMENT + jpeg.copyOfRange(HEAD_BYTES, jpeg.size)

        private inline fun forEachBit(number: Long, put: (pixel: Int, bit: Boolean) -> Unit) {
            for (pixel in 0 until Int.SIZE_BITS) put(pixel, number shr (Int.SIZE_BITS - 1 - pixel) and 1L == 1L)
        }
    }
}
