package dev.ml2sensors.stream

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TestTimeSource

class BackOffTest {
    private val time = TestTimeSource()
    private val backOff = BackOff(time)

    @Test
    fun pausesGrowToASecond() {
        val pauses = List(7) { failAfter(0.seconds).inWholeMilliseconds }
        assertEquals(listOf<Long>(50, 100, 200, 400, 800, 1000, 1000), pauses)
    }

    @Test
    fun theTimeOfAnAttemptCounts() {
        repeat(6) { failAfter(0.seconds) }
        assertEquals(700.milliseconds, failAfter(300.milliseconds))
    }

    @Test
    fun aLongAttemptIsFollowedByTheNextAtOnce() {
        repeat(6) { failAfter(0.seconds) }
        assertEquals(Duration.ZERO, failAfter(3.seconds))
    }

    @Test
    fun successBringsShortPausesBack() {
        repeat(6) { failAfter(0.seconds) }
        backOff.begin()
        backOff.succeeded()
        assertEquals(50.milliseconds, backOff.pause())
    }

    private fun failAfter(duration: Duration): Duration {
        backOff.begin()
        time += duration
        return backOff.pause().also { time += it }
    }
}
