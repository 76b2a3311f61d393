package dev.ml2sensors.simulator.simulated

import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.hours
import kotlin.time.Duration.Companion.seconds

class DrawnFaultsTest {
    private val faults = List(FAULTS) { key("fault.$it", default = "${it % 2 - 1}", most = 1.0 + it * it) }
    private val keys = faults + key("seed", default = "1", most = 9.0)

    private fun key(name: String, default: String, most: Double) =
        SimulatedKey(name, default, default, isText = false, isWhole = true, default.toDouble()..most, "")

    private fun drawn(seed: Long, duration: Duration) = drawnFaults(seed, keys, duration).toList()

    @Test
    fun aSeedAlwaysGivesTheSameFaults() {
        fun timeline(seed: Long) = drawn(seed, 60.seconds).map { "$it@${it.after}" }
        assertEquals(timeline(seed = 1), timeline(seed = 1))
        assertNotEquals(timeline(seed = 1), timeline(seed = 2))
    }

    @Test
    fun everyFaultOfTheTableComesAndNothingElse() {
        assertEquals(faults.map { it.name }.toSet(), drawn(seed = 1, duration = 1.hours).map { it.key }.toSet())
    }

    @Test
    fun valuesAreInTheRangeOfTheirKey() {
        for (setting in drawn(seed = 1, duration = 1.hours)) {
            val key = faults.single { it.name == setting.key }
            val isAllowed = setting.value == key.default || setting.value.toDouble() in 1.0..key.range.endInclusive
            assertTrue(isAllowed, "$setting")
        }
    }

    @Test
    fun allFaultsHaveEndedWhenTheQuietTimeBegins() {
        for (duration in listOf(60.seconds, 1.hours)) {
            val timeline = drawn(seed = 1, duration)
            assertEquals(timeline.map { it.after }, timeline.mapNotNull { it.after }.sorted())
            assertTrue(timeline.all { it.after!! <= duration - quietTime(duration) })
            val last = timeline.associate { it.key to it.value }
            assertEquals(faults.filter { it.name in last }.associate { it.name to it.default }, last)
        }
    }

    private companion object {
        const val FAULTS = 30
    }
}
