package dev.ml2sensors.session

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.minutes
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TestTimeSource

class SilenceTest {
    private val time = TestTimeSource()
    private val silence = Silence(time)

    @Test
    fun silenceIsTheTimeSinceTheLastFrame() {
        assertEquals(2.5.seconds, pass(2.5.seconds))
        time += 100.milliseconds
        silence.end()
        assertEquals(Duration.ZERO, silence.lasted())
        assertEquals(750.milliseconds, pass(750.milliseconds))
        silence.end()
        time += 200.milliseconds
        assertEquals(200.milliseconds, silence.lasted())
    }

    @Test
    fun aBusyHeadsetThatAsksLateCountsThatTime() {
        time += 900.milliseconds
        silence.lasted()
        time += 900.milliseconds
        assertEquals(1.8.seconds, silence.lasted())
    }

    @Test
    fun aHeadsetThatStoodStillFirstHearsWhatCameMeanwhile() {
        repeat(3) {
            pass(1.5.seconds)
            time += 1.minutes
            assertEquals(2.5.seconds, silence.lasted())
            silence.end()
        }
        time += 1.minutes
        assertEquals(1.seconds, silence.lasted(), "a standstill after a frame")
        time += 1.minutes
        silence.lasted()
        assertEquals(3.5.seconds, pass(1.5.seconds), "a standstill adds no patience to what follows")
    }

    @Test
    fun aFrameAfterAStandstillGrantsNoMoreTimeThanAnother() {
        time += 1.minutes
        silence.end()
        assertEquals(1.5.seconds, pass(1.5.seconds))
    }

    /** Asks as often as a session does, and returns the last answer. */
    private fun pass(duration: Duration): Duration {
        val ticks = (duration / 250.milliseconds).toInt()
        return (1..ticks).map {
            time += 250.milliseconds
            silence.lasted()
        }.last()
    }
}
