package dev.ml2sensors.source

import dev.ml2sensors.message.assertMatrix
import dev.ml2sensors.message.interpolate
import dev.ml2sensors.message.toMatrix
import dev.ml2sensors.message.transform
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertIs

class HeadTrackTest {
    private val track = HeadTrack()
    private val random = Random(3)
    private val heads = List(200) { random.transform() }

    @Test
    fun betweenTwoPosesTheHeadIsBetweenThem() {
        head(0)
        head(1)
        val found = assertIs<HeadPose.Tracked>(track.at(40))
        assertMatrix(heads[0].interpolate(heads[1], 0.4).toMatrix(), found.pose.toMatrix())
    }

    @Test
    fun atAPoseTheHeadIsThereHoweverOftenItIsSaid() {
        head(0)
        head(0)
        assertMatrix(heads[0].toMatrix(), assertIs<HeadPose.Tracked>(track.at(0)).pose.toMatrix())
    }

    @Test
    fun afterTheLatestPoseNothingIsKnownYet() {
        assertEquals(HeadPose.NotYetKnown, track.at(0))
        head(0)
        assertEquals(HeadPose.NotYetKnown, track.at(1))
    }

    @Test
    fun beforeThePosesThatAreKeptAndBetweenLostOnesItIsLost() {
        repeat(100) { head(it) }
        assertIs<HeadPose.Tracked>(track.at(9_850))
        assertEquals(HeadPose.Lost, track.at(350))
        track.lose()
        head(102)
        assertEquals(HeadPose.Lost, track.at(10_100))
        track.clear()
        head(104)
        assertEquals(HeadPose.NotTracked, track.at(10_300))
    }

    @Test
    fun betweenAPoseAndALossTheHeadIsNotTracked() {
        head(0)
        track.add(PoseSample(100, null))
        head(2)
        for (nanos in listOf(40L, 100L, 140L)) assertEquals(HeadPose.NotTracked, track.at(nanos))
        assertIs<HeadPose.Tracked>(track.at(200))
    }

    @Test
    fun posesOfTwoWorldsAreNotInterpolated() {
        head(0)
        track.add(PoseSample(100, heads[1], isInNewWorld = true))
        assertEquals(HeadPose.NotTracked, track.at(40))
    }

    private fun head(number: Int) = track.add(PoseSample(number * 100L, heads[number]))
}
