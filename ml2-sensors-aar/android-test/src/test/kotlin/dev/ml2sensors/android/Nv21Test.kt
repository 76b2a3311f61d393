package dev.ml2sensors.android

import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertContentEquals

class Nv21Test {
    @Test
    fun anyStridesGiveTheSamePicture() {
        val random = Random(1)
        repeat(500) { round ->
            val picture = Picture(random.nextInt(1, 40), random.nextInt(1, 30), random)
            val nv21 = Nv21(picture.width, picture.height)
            val target = ByteArray(nv21.sizeBytes)
            // The strides may change from one image to the next
            repeat(2) {
                nv21.copy(picture.planes(random), target)
                assertContentEquals(picture.toNv21(), target, "round $round, ${picture.width}x${picture.height}")
            }
        }
    }
}
