package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import org.junit.jupiter.api.Timeout
import kotlin.test.assertEquals
import kotlin.test.assertIs

/** 30 and 60 Hz are not to be had under light of 50 Hz mains, 25 and 50 Hz not under that of 60 Hz mains. */
@Timeout(60)
class DepthRatesTest {
    private val fixture = CaptureFixture()

    @AfterEach
    fun close(): Unit = fixture.close()

    private fun negotiate(rateHz: Int): Answer =
        fixture.depth.negotiate(StreamTable.depth, CaptureFixture.SHORT_RANGE.copy(rateHz = rateHz))

    private fun adjusted(rateHz: Int): StreamValues {
        val answer = assertIs<Answer.Adjusted>(negotiate(rateHz))
        assertEquals(CaptureFixture.SHORT_RANGE, answer.values.copy(rateHz = 30))
        return answer.values
    }

    @Test
    fun theNearestRateThatTheCameraHasHereIsAnsweredAndDelivered() = runBlocking<Unit> {
        Simulation.configure("mains_hz", 50)
        val values = adjusted(rateHz = 30)
        assertEquals(25, values.rateHz)
        assertEquals(50, adjusted(rateHz = 60).rateHz)
        assertIs<Answer.Applied>(negotiate(rateHz = 25))
        fixture.image(StreamTable.depth, values) { assertEquals(544, it.width) }
    }

    @Test
    fun aRateThatDeliversAnotherIsNoneToGoTo() {
        Simulation.configure("mains_hz", 60)
        assertEquals(30, adjusted(rateHz = 50).rateHz)
        assertEquals(30, adjusted(rateHz = 60).rateHz)
        assertIs<Answer.Applied>(negotiate(rateHz = 30))
    }

    @Test
    fun theReasonSaysWhatTheCameraHas() {
        Simulation.configure("mains_hz", 50)
        assertEquals(
            "update_rate 30: in the present mains-powered light the depth camera offers 5, 25, 50",
            assertIs<Answer.Adjusted>(negotiate(rateHz = 30)).reason,
        )
    }

    @Test
    fun aCameraThatCannotBeAskedIsTakenAsTheTableHasIt() {
        Simulation.configure("fault.depth.permission", 1)
        assertIs<Answer.Applied>(negotiate(rateHz = 30))
        Simulation.configure("fault.depth.permission", 0)
        Simulation.configure("mains_hz", 50)
        assertEquals(25, adjusted(rateHz = 30).rateHz)
    }
}
