package dev.ml2sensors.message

import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

class TimeTest {
    @Test
    fun secondsAreRoundedDownSoThatNanosecondsArePositive() {
        assertEquals(Time(1_700_000_000, 123_456_789u), Time.ofNanos(1_700_000_000_123_456_789))
        assertEquals(Time(-1, 999_999_999u), Time.ofNanos(-1))
        assertEquals(Time(-2, 0u), Time.ofNanos(-2_000_000_000))
    }

    @Test
    fun nanosecondsSurviveTheWayThereAndBack() {
        val random = Random(1)
        repeat(1000) {
            val nanos = random.nextLong(Int.MIN_VALUE * 1_000_000_000L, (Int.MAX_VALUE + 1L) * 1_000_000_000L)
            val time = Time.ofNanos(nanos)
            assertTrue(time.nanosec < 1_000_000_000u)
            assertEquals(nanos, time.toNanos())
        }
    }

    @Test
    fun aTimeBeyondTheRangeOfRosIsRefused() {
        val firstBeyond = (Int.MAX_VALUE + 1L) * 1_000_000_000L
        assertEquals(Time(Int.MAX_VALUE, 999_999_999u), Time.ofNanos(firstBeyond - 1))
        assertFailsWith<IllegalArgumentException> { Time.ofNanos(firstBeyond) }
        assertFailsWith<IllegalArgumentException> { Time.ofNanos(Long.MIN_VALUE) }
    }
}
