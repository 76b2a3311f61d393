package dev.ml2sensors.simulator.simulated

import kotlin.test.Test
import kotlin.test.assertFalse
import kotlin.test.assertTrue

class OpeningTest {
    private var nowMillis = 1_000L
    private var isDrawing = false
    private val opening = Opening({ nowMillis * 1_000_000 }, { isDrawing })

    private fun isOverAfter(millis: Long): Boolean {
        nowMillis += millis
        return opening.isOver()
    }

    @Test
    fun withoutPicturesToDrawItLastsAFifthOfASecond() {
        assertFalse(isOverAfter(0))
        assertFalse(isOverAfter(199))
        assertTrue(isOverAfter(2))
    }

    @Test
    fun itLastsAFifthOfASecondBeyondTheLastPicture() {
        assertFalse(isOverAfter(0))
        isDrawing = true
        repeat(10) { assertFalse(isOverAfter(300)) }
        isDrawing = false
        assertFalse(isOverAfter(199))
        isDrawing = true
        assertFalse(isOverAfter(1))
        isDrawing = false
        assertFalse(isOverAfter(200))
        assertTrue(isOverAfter(1))
    }

    @Test
    fun camerasThatStartLaterDoNotStopTheOthers() {
        assertFalse(isOverAfter(0))
        assertTrue(isOverAfter(300))
        isDrawing = true
        assertTrue(isOverAfter(0))
    }
}
