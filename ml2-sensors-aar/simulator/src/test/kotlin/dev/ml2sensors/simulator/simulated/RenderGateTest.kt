package dev.ml2sensors.simulator.simulated

import kotlin.test.Test
import kotlin.test.assertFalse
import kotlin.test.assertTrue

class RenderGateTest {
    private var nowMillis = 1_000L
    private var isDrawing = false
    private val renderGate = RenderGate({ nowMillis * 1_000_000 }, { isDrawing })

    private fun isOpenAfter(millis: Long): Boolean {
        nowMillis += millis
        return renderGate.isOpen()
    }

    @Test
    fun withoutRenderingItOpensAfter200Millis() {
        assertFalse(isOpenAfter(0))
        assertFalse(isOpenAfter(199))
        assertTrue(isOpenAfter(2))
    }

    @Test
    fun itOpens200MillisAfterTheLastFrameIsRendered() {
        assertFalse(isOpenAfter(0))
        isDrawing = true
        repeat(10) { assertFalse(isOpenAfter(300)) }
        isDrawing = false
        assertFalse(isOpenAfter(199))
        isDrawing = true
        assertFalse(isOpenAfter(1))
        isDrawing = false
        assertFalse(isOpenAfter(200))
        assertTrue(isOpenAfter(1))
    }

    @Test
    fun anOpenGateNeverClosesAgain() {
        assertFalse(isOpenAfter(0))
        assertTrue(isOpenAfter(300))
        isDrawing = true
        assertTrue(isOpenAfter(0))
    }
}
