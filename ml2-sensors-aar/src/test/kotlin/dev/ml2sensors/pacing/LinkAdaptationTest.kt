package dev.ml2sensors.pacing

import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.Tag
import org.junit.jupiter.api.Test
import org.junit.jupiter.params.ParameterizedTest
import org.junit.jupiter.params.provider.ValueSource
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue

@Tag("long-computation")
class LinkAdaptationTest {
    @ParameterizedTest
    @ValueSource(ints = [260, 500, 1000])
    fun aLinkThatCarriesEverythingChangesNothing(mbit: Int) {
        val scenario = AdaptationScenario(compressed(), seed = mbit)
        repeat(600) { scenario.run(mbit.toDouble(), seconds = 1) }
        assertEquals(emptyList(), scenario.changes)
    }

    @Test
    fun atHundredMbitTheWorldCamerasKeepTheirRate() {
        val scenario = AdaptationScenario(compressed(), seed = 1, spread = 0.0)
        scenario.run(mbit = 90.0, seconds = 60)
        assertEquals(listOf(30, 30, 30), scenario.streams.filter { "world" in it.id }.map { it.present.rateHz })
        assertNotEquals(0, scenario.changes.size)
    }

    @Test
    fun atThirtyMbitTheFirstCamerasHaveTenImagesPerSecond() {
        val scenario = AdaptationScenario(compressed(), seed = 2, spread = 0.0)
        scenario.run(mbit = 20.0, seconds = 60)
        val first = scenario.streams.filter { it.id == "world_left" || it.id == "world_right" }
        assertTrue(first.all { it.present.rateHz >= 10 }, "${first.map { it.present }}")
    }

    @Test
    fun mostOfALinkIsUsedInFewStepsAndNoCameraStarves() {
        for (mbit in listOf(50, 60, 70, 85, 100, 120, 140, 160, 180)) {
            val uses = (1..10).map { seed ->
                val scenario = AdaptationScenario(compressed(), seed)
                scenario.run(mbit.toDouble(), seconds = 10)
                val before = scenario.changes.size
                val use = (1..60).map {
                    scenario.run(mbit.toDouble(), seconds = 1)
                    assertTrue(scenario.streams.all { it.present.rateHz >= 5 }, "seed $seed, $mbit Mbit/s")
                    minOf(1.0, scenario.neededMbit / mbit)
                }
                val steps = scenario.changes.size - before
                assertTrue(steps <= 6, "seed $seed, $mbit Mbit/s: $steps steps")
                use.average()
            }
            assertTrue(uses.average() > 0.85, "$mbit Mbit/s: $uses")
        }
    }

    @Test
    fun aConstantLinkIsNeverOscillatedOn() {
        repeat(200) { seed ->
            val random = Random(seed)
            val mbit = 5 * Math.pow(100.0, random.nextDouble())
            val scenario = AdaptationScenario(anyStreams(random), seed)
            scenario.run(mbit, seconds = 180)
            val before = scenario.changes.size
            scenario.run(mbit, seconds = 60 * MINUTES)
            val steps = scenario.changes.size - before
            assertTrue(steps <= 3 * MINUTES, "seed $seed, $mbit Mbit/s: $steps steps in $MINUTES min")
        }
    }

    @Test
    fun noStreamGivesWayBeforeOneOfLowerRank() {
        repeat(200) { seed ->
            val random = Random(seed)
            val scenario = AdaptationScenario(anyStreams(random), seed) { it.requireOrder() }
            repeat(20) { scenario.run(mbit = 5 * Math.pow(100.0, random.nextDouble()), seconds = 10) }
        }
    }

    @Test
    fun aLinkThatGetsWorseIsFollowedWithinSecondsAndComesBack() {
        val scenario = AdaptationScenario(compressed(), seed = 3)
        scenario.run(mbit = 250.0, seconds = 20)
        assertEquals(0, scenario.adaptation.level)
        scenario.run(mbit = 20.0, seconds = 5)
        assertTrue(scenario.neededMbit < 20, "${scenario.neededMbit} Mbit/s are sent")
        scenario.run(mbit = 20.0, seconds = 5)
        scenario.run(mbit = 250.0, seconds = 120)
        assertEquals(0, scenario.adaptation.level)
    }

    @Test
    fun aLinkThatBecomesBetterIsUsedSoonAlthoughItBecameWorseBetween() {
        val scenario = AdaptationScenario(compressed(), seed = 6)
        scenario.run(mbit = 90.0, seconds = 30)
        repeat(5) {
            scenario.run(mbit = 15.0, seconds = 10)
            scenario.run(mbit = 90.0, seconds = 20)
            assertTrue(scenario.neededMbit > 50, "${scenario.neededMbit} Mbit/s in round $it")
        }
    }

    @Test
    fun aBacklogOfImagesThatTheLinkCarriesHasTwoSecondsToGo() {
        for ((allowed, seconds) in listOf(1.1 to 2.0, 0.9 to 0.5)) {
            val streams = compressed().onEach { it.published(bytes = 100_000, it.configured) }
            val needed = streams.sumOf { it.bytesPerSecond(it.configured) }
            val adaptation = LinkAdaptation(streams, StreamTable.adaptation, nowNanos = 0)
            val first = (1..30).first { tenth ->
                val sent = (needed * tenth / 10).toLong()
                adaptation.adaptTo(LinkState(0, false, tenth.toLong(), sent, allowed * needed), tenth * SECOND / 10)
            }
            assertEquals(seconds, first / 10.0, "$allowed of what is needed is allowed")
        }
    }

    @Test
    fun aLinkThatStandsStillChangesNothing() {
        val scenario = AdaptationScenario(compressed(), seed = 4)
        scenario.run(mbit = 250.0, seconds = 10)
        scenario.run(mbit = 0.0, seconds = 5)
        scenario.run(mbit = 250.0, seconds = 60)
        assertEquals(emptyList(), scenario.changes)
    }

    @Test
    fun aNewSessionIsJudgedByItsOwnBytes() {
        val (only, second) = List(2) {
            val streams = compressed().onEach { it.published(bytes = 100_000, it.configured) }
            LinkAdaptation(streams, StreamTable.adaptation, nowNanos = 0)
        }
        second.adaptTo(LinkState(null, false, 0, sentBytes = 25_000_000, 25e6), 0)
        for (i in 1..10) {
            val link = LinkState(SECOND, false, droppedImages = i.toLong(), sentBytes = i * 2_000_000L, 20e6)
            for (adaptation in listOf(only, second)) adaptation.adaptTo(link, SECOND + i * SECOND / 10)
        }
        assertNotEquals(0, only.level)
        assertEquals(only.level, second.level)
    }

    @Test
    fun newStreamsBeginAsLowAsTheOthersAre() {
        val scenario = AdaptationScenario(compressed(), seed = 5)
        scenario.run(mbit = 30.0, seconds = 20)
        val kept = scenario.streams.filter { "world" in it.id }
        val eyes = compressed().filter { "eye" in it.id }
        val before = kept.map { it.present }
        LinkAdaptation(kept + eyes, StreamTable.adaptation, scenario.nowNanos)
        assertEquals(before, kept.map { it.present })
        assertTrue(eyes.all { it.present.quality == 40 }, "${eyes.map { it.present }}")
    }

    /** Asserts that nothing is lowered as long as a stream that gives way earlier has more. */
    private fun List<AdaptedStream>.requireOrder() {
        val order = StreamTable.adaptation
        val rank = { it: AdaptedStream -> order.streams.indexOfFirst { group -> it.id in group } }
        for (high in this) {
            for (low in filter { rank(it) < rank(high) }) {
                val isSecondRound = high.present.rateHz < order.firstRoundHz[rank(high)]
                val mostHz = when {
                    isSecondRound -> order.ratesHz.last()
                    high.present.rateHz < high.configured.rateHz -> order.firstRoundHz[rank(low)]
                    else -> low.configured.rateHz
                }
                assertTrue(low.present.rateHz <= mostHz, "${high.id} before ${low.id}")
                val isQualityLow = high.present.quality != high.configured.quality
                val lowQuality = low.present.quality
                if (isQualityLow && lowQuality != null) assertTrue(lowQuality <= checkNotNull(high.present.quality))
            }
            if (high.present.rateHz < high.configured.rateHz) {
                assertTrue(all { (it.present.quality ?: 0) <= 40 }, "a rate was lowered before a quality")
            }
        }
    }

    private companion object {
        const val SECOND = 1_000_000_000L
        const val MINUTES = 10
        val WORLD = listOf("world_center", "world_left", "world_right")
        val EYES = listOf("eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right")

        fun jpeg(id: String) = AdaptedStream(id, ImageSetting(rateHz = 30, quality = 80))

        /** All cameras, compressed. */
        fun compressed(): List<AdaptedStream> = WORLD.map(::jpeg) + EYES.map(::jpeg) +
            listOf("color", "depth").map { AdaptedStream(it, ImageSetting(rateHz = 30, quality = null)) }

        fun anyStreams(random: Random): List<AdaptedStream> = compressed()
            .filter { random.nextInt(4) > 0 }
            .map { AdaptedStream(it.id, if (random.nextBoolean()) it.configured else ImageSetting(30, null)) }
            .ifEmpty { listOf(jpeg("world_left")) }
    }
}
