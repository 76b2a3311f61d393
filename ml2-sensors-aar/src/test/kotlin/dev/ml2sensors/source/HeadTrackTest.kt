package dev.ml2sensors.stream

import dev.ml2sensors.message.assertMatrix
import dev.ml2sensors.message.interpolate
import dev.ml2sensors.message.toMatrix
import dev.ml2sensors.message.transform
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.wire.Event
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertIs

class HeadTrackTest {
    private val events = mutableListOf<Event>()
    private val track = HeadTrack(events::add)
    private val random = Random(3)
    private val heads = List(200) { random.transform() }

    @Test
    fun betweenTwoPosesTheHeadIsBetweenThem() {
        head(0)
        head(1)
        val found = assertIs<HeadAt.Tracked>(track.at(40))
        assertMatrix(heads[0].interpolate(heads[1], 0.4).toMatrix(), found.pose.toMatrix())
    }

    @Test
    fun atAPoseTheHeadIsThereHoweverOftenItIsSaid() {
        head(0)
        head(0)
        assertMatrix(heads[0].toMatrix(), assertIs<HeadAt.Tracked>(track.at(0)).pose.toMatrix())
    }

    @Test
    fun afterTheLatestPoseNothingIsKnownYet() {
        assertEquals(HeadAt.NotYetKnown, track.at(0))
        head(0)
        assertEquals(HeadAt.NotYetKnown, track.at(1))
    }

    @Test
    fun beforeThePosesThatAreKeptAndBetweenLostOnesItIsLost() {
        repeat(100) { head(it) }
        assertIs<HeadAt.Tracked>(track.at(9_850))
        assertEquals(HeadAt.Lost, track.at(350))
        track.lose()
        head(102)
        assertEquals(HeadAt.Lost, track.at(10_100))
        track.clear()
        head(104)
        assertEquals(HeadAt.NotTracked, track.at(10_300))
    }

    @Test
    fun betweenAPoseAndALossTheHeadIsNotTracked() {
        head(0)
        track.add(PoseSample(100, null))
        head(2)
        for (nanos in listOf(40L, 100L, 140L)) assertEquals(HeadAt.NotTracked, track.at(nanos))
        assertIs<HeadAt.Tracked>(track.at(200))
    }

    @Test
    fun posesOfTwoWorldsAreNotInterpolated() {
        head(0)
        track.add(PoseSample(100, heads[1], isInNewWorld = true))
        assertEquals(HeadAt.NotTracked, track.at(40))
    }

    @Test
    fun theHeadIsNotLostBeforeItWasEverTracked() {
        track.add(PoseSample(0, null, isInNewWorld = true))
        head(1)
        assertEquals(emptyList(), events)
    }

    @Test
    fun aNewWorldWhileTheHeadIsLostIsReportedBesideItsRecovery() {
        head(0)
        track.add(PoseSample(100, null))
        track.add(PoseSample(200, heads[2], isInNewWorld = true))
        assertEquals(
            listOf(Event.TRACKING_LOST, Event.TRACKING_NEW_SESSION, Event.TRACKING_RECOVERED),
            events.map { it.event },
        )
    }

    private fun head(number: Int) = track.add(PoseSample(number * 100L, heads[number]))
}
