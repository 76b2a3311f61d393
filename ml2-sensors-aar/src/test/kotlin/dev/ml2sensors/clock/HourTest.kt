package dev.ml2sensors.clock

import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** An hour of virtual time with a host that steps and slews, and a link that breaks. */
class HourTest {
    private val random = Random(11)
    private val end = BEGIN + 3_600 * SECOND

    /** Every few minutes, alternating; the first is before the first outage. */
    private val steps = listOf(
        SECOND,
        -SECOND,
        -SECOND,
        3 * SECOND,
        -3 * SECOND,
        -20 * MILLI,
        20 * MILLI,
        -1_900 * MILLI,
    )

    private fun hostOffset(at: Long): Long {
        val elapsed = at - BEGIN
        val stepped = steps.take((elapsed / STEP_INTERVAL).toInt()).sum()
        // A minute of 200 ppm in every ten
        val slewed = elapsed / SLEW_INTERVAL * 60 * SECOND + (elapsed % SLEW_INTERVAL).coerceAtMost(60 * SECOND)
        return 1_700_000_000 * SECOND + stepped + slewed / 5_000 + elapsed / 1_000_000 * 20
    }

    @Test
    fun stampsStrictlyIncreaseWithinAnEpochForAnHour() {
        val time = VirtualTime(VirtualNetwork.symmetric(random), ::hostOffset)
        val map = time.clock.stamps
        var epoch = 0L
        var last = Long.MIN_VALUE
        var withheld = 0
        val capture = { at: Long ->
            if (map.epoch != epoch) last = Long.MIN_VALUE
            epoch = map.epoch
            val stamp = map.stampNanos(at)
            assertEquals(stamp, map.stampNanos(at), "another sensor at this instant")
            if (stamp == null) withheld++ else assertTrue(stamp > last, "$stamp after $last in epoch $epoch")
            last = stamp ?: last
        }
        while (time.now < end) {
            time.run(time.now + random.nextLong(10 * SECOND, 100 * SECOND), linked = true, capture)
            time.clock.endSession()
            time.run(time.now + random.nextLong(20 * SECOND), linked = false, capture)
            time.linkUp()
        }
        val back = steps.filter { it in -2 * SECOND..0 }
        assertEquals(steps.size.toLong(), time.clock.status.steps)
        assertEquals((steps.size - back.size).toLong(), epoch)
        val expected = -back.sum() * 60 / SECOND
        assertTrue(withheld in expected - 10..expected + 10, "$withheld captures withheld, expected $expected")
    }

    @Test
    fun whatIsWithheldIsNotStampedLater() {
        val time = VirtualTime(VirtualNetwork.idle(random)) { if (it < BEGIN + 10 * SECOND) SECOND else 0 }
        val withheld = mutableListOf<Long>()
        time.run(BEGIN + 60 * SECOND, linked = true) { if (time.clock.stamps.stampNanos(it) == null) withheld += it }
        assertTrue(withheld.size in 58..62, "a second at 60 Hz: ${withheld.size}")
        for (at in withheld) assertNull(time.clock.stamps.stampNanos(at))
    }

    private companion object {
        const val BEGIN = 1_000 * SECOND
        const val STEP_INTERVAL = 421 * SECOND
        const val SLEW_INTERVAL = 600 * SECOND
    }
}
