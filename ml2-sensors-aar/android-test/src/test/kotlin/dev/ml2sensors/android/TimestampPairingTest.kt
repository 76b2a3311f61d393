package dev.ml2sensors.android

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class TimestampPairingTest {
    private val pairs = mutableListOf<Pair<String, Int>>()
    private val alone = mutableListOf<String>()
    private val pairing = TimestampPairing<String, Int>({ image, result -> pairs += image to result }, { alone += it })

    @Test
    fun whatHasTheSameTimestampComesTogetherWhicheverIsFirst() {
        pairing.image(10, "a")
        pairing.result(10, 1)
        pairing.result(20, 2)
        pairing.result(30, 3)
        pairing.image(20, "b")
        pairing.image(30, "c")
        assertEquals(listOf("a" to 1, "b" to 2, "c" to 3), pairs)
    }

    @Test
    fun anImageThatIsOvertakenStaysAlone() {
        pairing.image(10, "a")
        pairing.image(20, "b")
        pairing.result(20, 2)
        assertEquals(listOf("b" to 2), pairs)
        assertEquals(listOf("a"), alone)
    }

    @Test
    fun aResultWithoutAnImageIsForgotten() {
        pairing.result(10, 1)
        pairing.result(20, 2)
        pairing.image(20, "b")
        assertEquals(listOf("b" to 2), pairs)
        assertEquals(emptyList(), alone)
    }

    @Test
    fun imagesDoNotWaitForEverForResultsThatNeverCome() {
        repeat(100) { pairing.image(it.toLong(), "$it") }
        assertEquals(List(84) { "$it" }, alone)
        repeat(100) { pairing.result(it.toLong(), it) }
        assertEquals(List(16) { "${it + 84}" to it + 84 }, pairs)
    }
}
