package dev.ml2sensors.stream

import dev.ml2sensors.source.Condition
import dev.ml2sensors.source.PoseSample
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class ConditionsTest {
    private val events = mutableListOf<String>()
    private val conditions = Conditions { events += "${it.event} ${it.text}" }

    private fun gaze(fit: String, isGood: Boolean = false) =
        Condition(isGood, "headset fit is $fit", mapOf("headset_fit" to fit))

    @Test
    fun eachChangeOfTheGazeIsReportedOnce() {
        for (condition in listOf("bad", "bad", "not_worn", "good", "good", "bad")) {
            conditions.set(Conditions.GAZE, gaze(condition, isGood = condition == "good"))
        }
        assertEquals(
            listOf(
                "gaze_unreliable gaze: headset fit is bad",
                "gaze_unreliable gaze: headset fit is not_worn",
                "gaze_reliable gaze: headset fit is good",
                "gaze_unreliable gaze: headset fit is bad",
            ),
            events,
        )
    }

    @Test
    fun aGazeThatIsGoodFromTheStartIsNoNewsAlsoIfTheHeadsetHadNotSaidItAtOnce() {
        conditions.set(Conditions.GAZE, gaze("not_said"))
        conditions.set(Conditions.GAZE, gaze("good", isGood = true))
        assertEquals(emptyList(), events)
    }

    @Test
    fun aStreamThatEndsAndBeginsAgainReportsNothingTwice() = runBlocking<Unit> {
        repeat(2) {
            conditions.watch(
                Conditions.GAZE,
                flow {
                    emit(PoseSample(0, null, condition = gaze("bad")))
                    assertEquals("warn", conditions.toBodies().getValue(Conditions.GAZE).level)
                },
            ).collect { }
            assertEquals(emptyMap(), conditions.toBodies())
        }
        assertEquals(1, events.size)
    }

    @Test
    fun theTrackingOfTheHeadHasEventsOfItsOwn() {
        conditions.set(Conditions.TRACKING, Condition(false, "the head is not tracked", emptyMap()))
        assertEquals(emptyList(), events)
        assertEquals("the head is not tracked", conditions.toBodies().getValue("tracking").message)
    }
}
