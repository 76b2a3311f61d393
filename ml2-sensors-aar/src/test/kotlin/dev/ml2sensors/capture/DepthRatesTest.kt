package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TestTimeSource

/** 30 and 60 Hz are not to be had under light of 50 Hz mains, 25 and 50 Hz not under that of 60 Hz mains. */
class DepthRatesTest {
    private val fixture = CaptureFixture()
    private val time = TestTimeSource()
    private val rates = DepthRates(time)

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
    fun ratesOf60HzMainsAreTakenAsAsked() {
        Simulation.configure("mains_hz", 60)
        assertEquals(60, adjusted(rateHz = 50).rateHz)
        for (rate in listOf(5, 30, 60)) assertIs<Answer.Applied>(negotiate(rate))
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
    fun whileTheCameraCannotBeAskedTheStreamWaitsWithTheReasonAndThePermission() {
        Simulation.configure("mains_hz", 50)
        Simulation.configure("fault.depth.permission", 1)
        val refused = assertIs<Answer.Refused>(adjust(rateHz = 30))
        assertEquals("com.magicleap.permission.DEPTH_CAMERA", refused.permission)
        assertContains(refused.reason, "cannot be asked yet for the rates")
        Simulation.configure("fault.depth.permission", 0)
        assertEquals(refused, adjust(rateHz = 30), "asked again too soon")
        time += 1.seconds
        assertEquals(25, assertIs<Answer.Adjusted>(adjust(rateHz = 30)).values.rateHz)
    }

    @Test
    fun aCameraThatFailsIsAskedLessAndLessOften() {
        Simulation.configure("fault.depth.connect", 1)
        var asked = 0
        var last: Answer? = null
        repeat(60) {
            val answer = adjust(rateHz = 30)
            if (answer !== last) asked++
            last = answer
            time += 1.seconds
        }
        // At 0, 1, 3, 7, 15, 31 and 47 s
        assertEquals(7, asked)
    }

    @Test
    fun ratesThatTheCameraHasInAnyLightNeedNoQuery() {
        Simulation.configure("fault.depth.connect", 1)
        assertIs<Answer.Applied>(adjust(rateHz = 5))
    }

    private fun adjust(rateHz: Int): Answer {
        val requested = CaptureFixture.SHORT_RANGE.copy(rateHz = rateHz)
        return rates.adjust(StreamTable.depth, requested, Answer.Applied(requested))
    }
}
