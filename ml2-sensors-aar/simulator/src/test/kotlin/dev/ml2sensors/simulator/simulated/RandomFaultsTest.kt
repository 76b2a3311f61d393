package dev.ml2sensors.simulator.simulated

import kotlin.test.Test
import kotlin.test.assertEquals
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.hours
import kotlin.time.Duration.Companion.seconds

class RandomFaultsTest {
    private val faults = List(FAULTS) { key("fault.$it", default = "${it % 2 - 1}", most = 1.0 + it * it) }
    private val faultsOfOpenXr = listOf("taken", "odd").map { choice("openxr.fault.sensor.$it") }
    private val others = listOf(key("seed", default = "1", most = 9.0), choice("clock"), choice("openxr.anything"))
    private val keys = faults + faultsOfOpenXr + others

    private fun key(name: String, default: String, most: Double) =
        SimulationKey(name, default, default, isText = false, isWhole = true, default.toDouble()..most, listOf(), "")

    private fun choice(name: String) =
        SimulationKey(name, "", "", isText = true, isWhole = false, 0.0..0.0, listOf("", "left", "right"), "")

    private fun timeline(seed: Long, duration: Duration) = randomFaults(seed, keys, duration).first().toList()

    @Test
    fun equalSeedsGiveEqualFaults() {
        fun texts(seed: Long) = timeline(seed, 60.seconds).map { "$it@${it.after}" }
        assertEquals(texts(seed = 1), texts(seed = 1))
        assertNotEquals(texts(seed = 1), texts(seed = 2))
    }

    @Test
    fun everyFaultKeyIsUsedAndNoOtherKey() {
        assertEquals(faults.map { it.name }.toSet(), timeline(seed = 1, duration = 1.hours).map { it.key }.toSet())
    }

    @Test
    fun openXrHasFaultsOfItsOwnWithEveryChoice() {
        val faults = randomFaults(seed = 1, keys, 1.hours).last().toList()
        assertEquals(faultsOfOpenXr.map { it.name }.toSet(), faults.map { it.key }.toSet())
        assertEquals(setOf("", "left", "right"), faults.map { it.value }.toSet())
    }

    @Test
    fun valuesAreWithinTheRangeOfTheirKey() {
        for (setting in timeline(seed = 1, duration = 1.hours)) {
            val key = faults.single { it.name == setting.key }
            val isAllowed = setting.value == key.default || setting.value.toDouble() in 1.0..key.range.endInclusive
            assertTrue(isAllowed, "$setting")
        }
    }

    @Test
    fun allFaultsHaveEndedAfterTheDuration() {
        for (duration in listOf(60.seconds, 1.hours)) {
            val timeline = timeline(seed = 1, duration)
            assertEquals(timeline.map { it.after }, timeline.mapNotNull { it.after }.sorted())
            assertTrue(timeline.all { it.after!! <= duration })
            val last = timeline.associate { it.key to it.value }
            assertEquals(faults.filter { it.name in last }.associate { it.name to it.default }, last)
        }
    }

    private companion object {
        const val FAULTS = 30
    }
}
