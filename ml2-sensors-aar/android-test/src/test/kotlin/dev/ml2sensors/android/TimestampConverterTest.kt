package dev.ml2sensors.android

import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.SourceException
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNull

class TimestampConverterTest {
    private val device = SettableClocks(monotonicNanos = 500 * SECOND, suspendedNanos = 7_000 * SECOND)
    private val found = mutableListOf<ClockDomain>()
    private val converter = TimestampConverter(device.clocks) { found += it }

    @Test
    fun aTimestampOfTheBootClockStaysAsItIs() {
        val timestamp = device.bootNanos - 5 * MILLI
        assertEquals(timestamp, converter.captureNanos(timestamp))
        assertEquals(listOf(ClockDomain.BOOTTIME), found)
    }

    @Test
    fun aTimestampOfTheMonotonicClockIsTakenToTheBootClock() {
        val age = 5 * MILLI
        assertEquals(device.bootNanos - age, converter.captureNanos(device.monotonicNanos - age))
        device.monotonicNanos += SECOND
        assertEquals(device.bootNanos - age, converter.captureNanos(device.monotonicNanos - age))
        assertEquals(listOf(ClockDomain.MONOTONIC), found)
    }

    @Test
    fun aSuspensionMovesTheTimestampsOfTheMonotonicClock() {
        converter.captureNanos(device.monotonicNanos)
        device.suspendedNanos += 30 * SECOND
        device.monotonicNanos += SECOND
        assertEquals(device.bootNanos - MILLI, converter.captureNanos(device.monotonicNanos - MILLI))
    }

    @Test
    fun whenBothClocksAreNearTheYoungerReadingDecides() {
        device.suspendedNanos = 100 * MILLI
        converter.captureNanos(device.monotonicNanos - 5 * MILLI)
        assertEquals(listOf(ClockDomain.MONOTONIC), found)
    }

    @Test
    fun aReadingFromTheFutureOfAClockIsNotOfThatClock() {
        device.suspendedNanos = 100 * MILLI
        val timestamp = device.bootNanos - 5 * MILLI
        assertEquals(timestamp, converter.captureNanos(timestamp))
        assertEquals(listOf(ClockDomain.BOOTTIME), found)
    }

    @Test
    fun aTimestampUpToFiveMillisecondsAheadIsOfTheClockItIsAheadOf() {
        assertNull(converter.captureNanos(device.bootNanos + 6 * MILLI))
        val timestamp = device.bootNanos + 5 * MILLI
        assertEquals(timestamp, converter.captureNanos(timestamp))
        assertEquals(listOf(ClockDomain.BOOTTIME), found)
    }

    @Test
    fun beforeAnySuspensionTheClocksAreOneToWithinAMillisecond() {
        device.suspendedNanos = 900
        converter.captureNanos(device.monotonicNanos - 5 * MILLI)
        assertEquals(listOf(ClockDomain.BOOTTIME), found)
    }

    @Test
    fun theFirstSuspensionTellsThatTheClockIsTheMonotonicOne() {
        device.suspendedNanos = 900
        converter.captureNanos(device.monotonicNanos - 5 * MILLI)
        device.suspendedNanos += 30 * SECOND
        assertNull(converter.captureNanos(device.monotonicNanos - MILLI), "the clock is not known again yet")
        device.monotonicNanos += SECOND
        assertEquals(device.bootNanos - MILLI, converter.captureNanos(device.monotonicNanos - MILLI))
        assertEquals(listOf(ClockDomain.BOOTTIME, ClockDomain.MONOTONIC), found)
    }

    @Test
    fun aReadingFromBeforeTheFirstSuspensionIsNotTakenForAFreshOneOfTheOtherClock() {
        device.suspendedNanos = 900
        val stale = device.bootNanos - MILLI
        converter.captureNanos(stale)
        device.suspendedNanos += 30 * SECOND
        assertNull(converter.captureNanos(stale + MILLI))
        device.monotonicNanos += SECOND
        val fresh = device.bootNanos - MILLI
        assertEquals(fresh, converter.captureNanos(fresh))
        assertEquals(listOf(ClockDomain.BOOTTIME, ClockDomain.BOOTTIME), found)
    }

    @Test
    fun anOldReadingIsLostUntilAFreshOneTellsTheClock() {
        val old = device.bootNanos - 60 * SECOND
        assertNull(converter.captureNanos(old))
        converter.captureNanos(device.bootNanos - MILLI)
        assertEquals(old, converter.captureNanos(old))
    }

    @Test
    fun aReadingAsOldAsTheDeviceWasSuspendedDoesNotDecideTheClock() {
        converter.captureNanos(device.bootNanos - 7_000 * SECOND - MILLI)
        repeat(5) {
            device.monotonicNanos += SECOND
            val timestamp = device.bootNanos - MILLI
            assertEquals(timestamp, converter.captureNanos(timestamp))
        }
        assertEquals(ClockDomain.BOOTTIME, found.last())
    }

    @Test
    fun theLastKnownValueOfAnOnChangeSensorHasItsOwnStampWhateverItsAge() {
        for (age in listOf(MILLI, 60 * SECOND, 3_600 * SECOND, 7_000 * SECOND + MILLI, 7_400 * SECOND)) {
            val onChange = TimestampConverter(device.clocks, isOnChange = true)
            assertEquals(device.bootNanos - age, onChange.captureNanos(device.bootNanos - age), "${age / SECOND} s old")
        }
    }

    @Test
    fun anOnChangeSensorOfTheMonotonicClockIsFoundAfterSomeReadings() {
        val onChange = TimestampConverter(device.clocks, isOnChange = true) { found += it }
        repeat(3) {
            device.monotonicNanos += SECOND
            onChange.captureNanos(device.monotonicNanos - MILLI)
        }
        assertEquals(listOf(ClockDomain.MONOTONIC), found)
        assertEquals(device.bootNanos, onChange.captureNanos(device.monotonicNanos))
    }

    @Test
    fun timestampsOfNoClockFailWithAllThreeNumbers() {
        val failure = assertFailsWith<SourceException> { repeat(100) { assertNull(converter.captureNanos(42)) } }
        assertEquals(
            "expected timestamps within a second of CLOCK_BOOTTIME (7500000000000) or CLOCK_MONOTONIC " +
                "(500000000000), found 42",
            failure.message,
        )
    }

    @Test
    fun theTightestBracketOfTheClocksIsKept() {
        val readings = longArrayOf(100, 110, 1_000, 5_000, 6_000, 6_020).iterator()
        val boot = longArrayOf(1_105, 4_500, 7_009).iterator()
        val offset = MonotonicOffset(SystemClocks(boot = { boot.nextLong() }, monotonic = { readings.nextLong() }))
        assertEquals(1_000, offset.nanos(), "between 100 and 110")
        assertEquals(1_000, offset.nanos(), "4500 - 3000 is uncertain by 2000, and tells nothing new")
        assertEquals(1_000, offset.nanos(), "7009 - 6010 is uncertain by 10")
    }

    private companion object {
        const val MILLI = 1_000_000L
        const val SECOND = 1_000_000_000L
    }
}

class TimestampMatchTest {
    private val pairs = mutableListOf<Pair<String, Int>>()
    private val alone = mutableListOf<String>()
    private val matching = TimestampMatch<String, Int>({ image, result -> pairs += image to result }, { alone += it })

    @Test
    fun whatHasTheSameTimestampComesTogetherWhicheverIsFirst() {
        matching.image(10, "a")
        matching.result(10, 1)
        matching.result(20, 2)
        matching.result(30, 3)
        matching.image(20, "b")
        matching.image(30, "c")
        assertEquals(listOf("a" to 1, "b" to 2, "c" to 3), pairs)
    }

    @Test
    fun anImageThatIsOvertakenStaysAlone() {
        matching.image(10, "a")
        matching.image(20, "b")
        matching.result(20, 2)
        assertEquals(listOf("b" to 2), pairs)
        assertEquals(listOf("a"), alone)
    }

    @Test
    fun aResultWithoutAnImageIsForgotten() {
        matching.result(10, 1)
        matching.result(20, 2)
        matching.image(20, "b")
        assertEquals(listOf("b" to 2), pairs)
        assertEquals(emptyList(), alone)
    }

    @Test
    fun imagesDoNotWaitForEverForResultsThatNeverCome() {
        repeat(100) { matching.image(it.toLong(), "$it") }
        assertEquals(List(84) { "$it" }, alone)
        repeat(100) { matching.result(it.toLong(), it) }
        assertEquals(List(16) { "${it + 84}" to it + 84 }, pairs)
    }
}

/** Clocks of a device that was suspended for [suspendedNanos] in all. */
internal class SettableClocks(@Volatile var monotonicNanos: Long, @Volatile var suspendedNanos: Long) {
    val clocks = SystemClocks(boot = { monotonicNanos + suspendedNanos }, monotonic = { monotonicNanos })
    val bootNanos: Long get() = clocks.boot.nowNanos()
}
