package dev.ml2sensors.source

import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.random.Random
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals

class YuvPlanesTest {
    private val random = Random(7)

    /** The layout of U and V in memory. */
    private enum class Layout { PLANAR, U_FIRST, V_FIRST, APART }

    @Test
    fun everyPixelComesToItsPlaceInEveryLayout() {
        for ((width, height) in listOf(16 to 8, 7 to 5, 1 to 1, 2 to 3, 1016 to 4)) {
            for (layout in Layout.entries) {
                for (isColor in listOf(true, false)) check(width, height, layout, isColor)
            }
        }
    }

    private fun check(width: Int, height: Int, layout: Layout, isColor: Boolean) {
        val what = "${width}x$height $layout, colour: $isColor"
        val (chromaWidth, chromaHeight) = (width + 1) / 2 to (height + 1) / 2
        val stride = width + random.nextInt(0, 4)
        val luma = random.nextBytes(height * stride)
        val chroma = random.nextBytes(2 * chromaWidth * chromaHeight)
        val target = Target(width, chromaWidth, height, chromaHeight, layout)
        val before = target.padding()
        YuvPlanes(width, height).copy(
            image(
                width,
                height,
                stride,
                luma,
                chroma.takeIf {
                    isColor
                },
            ),
            target.y,
            target.u,
            target.v,
        )
        for (row in 0 until height) {
            val expected = luma.copyOfRange(row * stride, row * stride + width)
            assertContentEquals(
                expected,
                ByteArray(width) {
                    target.y.bytes[row * target.y.rowStride + it]
                },
                "$what: y",
            )
        }
        for (row in 0 until chromaHeight) {
            for (column in 0 until chromaWidth) {
                val pair = 2 * (row * chromaWidth + column)
                val (v, u) = if (isColor) chroma[pair] to chroma[pair + 1] else NO_COLOR to NO_COLOR
                assertEquals(u, target.u.at(row, column), "$what: u")
                assertEquals(v, target.v.at(row, column), "$what: v")
            }
        }
        assertContentEquals(before, target.padding(), "$what: nothing else is written")
    }

    private fun YuvPlane.at(row: Int, column: Int) = bytes[row * rowStride + column * pixelStride]

    private fun image(width: Int, height: Int, stride: Int, luma: ByteArray, chroma: ByteArray?): ImageSample {
        val planes = listOfNotNull(
            ImageSample.Plane(ImageSample.IMAGE, atOddPlace(luma)),
            chroma?.let { ImageSample.Plane(ImageSample.CHROMA, atOddPlace(it)) },
        )
        return ImageSample(1, 1, width, height, stride, null, null, CaptureMetadata(), planes) {}
    }

    private fun atOddPlace(bytes: ByteArray): ByteBuffer =
        ByteBuffer.allocateDirect(bytes.size + 8).position(3).put(bytes).position(3).limit(3 + bytes.size)

    /** Planes of an encoder, none longer than to its last value, in memory full of noise. */
    private inner class Target(width: Int, chromaWidth: Int, height: Int, chromaHeight: Int, layout: Layout) {
        private val memory = direct(random.nextBytes(4 * (width + 16) * (height + 2)))
        private val isOfRow = BooleanArray(memory.capacity())
        private val lumaStride = width + 5
        private val step = if (layout == Layout.PLANAR) 1 else 2
        private val chromaStride = step * chromaWidth + 3
        private val chroma = lumaStride * height
        private val apart = chromaStride * chromaHeight + 1
        val y = plane(0, width, height, lumaStride, pixelStride = 1)
        val u = chroma(chromaWidth, chromaHeight, if (layout == Layout.V_FIRST) 1 else 0)
        val v = when (layout) {
            Layout.U_FIRST -> chroma(chromaWidth, chromaHeight, 1)
            Layout.V_FIRST -> chroma(chromaWidth, chromaHeight, 0)
            else -> chroma(chromaWidth, chromaHeight, apart)
        }

        private fun chroma(width: Int, height: Int, offset: Int) = plane(
            chroma + offset,
            width,
            height,
            chromaStride,
            step,
        )

        private fun plane(offset: Int, width: Int, height: Int, rowStride: Int, pixelStride: Int): YuvPlane {
            val rowBytes = (width - 1) * pixelStride + 1
            for (row in 0 until height) {
                isOfRow.fill(
                    true,
                    offset + row * rowStride,
                    offset + row * rowStride + rowBytes,
                )
            }
            val size = (height - 1) * rowStride + rowBytes
            return YuvPlane(memory.duplicate().position(offset).limit(offset + size).slice(), rowStride, pixelStride)
        }

        /** The bytes between the rows of the planes, and behind them. */
        fun padding(): ByteArray = isOfRow.indices.filter { !isOfRow[it] }.map { memory[it] }.toByteArray()
    }

    private companion object {
        const val NO_COLOR = 128.toByte()

        fun direct(bytes: ByteArray): ByteBuffer = ByteBuffer.allocateDirect(bytes.size).put(bytes).flip()
    }
}
