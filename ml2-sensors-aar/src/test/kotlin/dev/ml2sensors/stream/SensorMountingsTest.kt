package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.assertMatrix
import dev.ml2sensors.message.interpolate
import dev.ml2sensors.message.times
import dev.ml2sensors.message.toMatrix
import dev.ml2sensors.message.transform
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals

class SensorMountingsTest {
    private val mountings = SensorMountings()
    private val random = Random(3)
    private val heads = List(200) { random.transform() }
    private val mounting = random.transform()

    @Test
    fun aFrameBetweenTwoHeadPosesGivesTheMounting() {
        head(0)
        head(1)
        mountings.camera(StreamTable.depth, 40, heads[0].interpolate(heads[1], 0.4) * mounting)
        assertMounted(StreamTable.depth)
    }

    @Test
    fun aFrameAtAHeadPoseGivesTheMounting() {
        head(0)
        mountings.camera(StreamTable.depth, 0, heads[0] * mounting)
        assertMounted(StreamTable.depth)
    }

    @Test
    fun aFrameAheadOfTheHeadWaitsForIt() {
        head(0)
        mountings.camera(StreamTable.depth, 40, heads[0].interpolate(heads[1], 0.4) * mounting)
        assertEquals(emptyMap(), found())
        head(1)
        assertMounted(StreamTable.depth)
    }

    @Test
    fun aFrameDeliveredLateGivesTheMounting() {
        repeat(30) { head(it) }
        mountings.camera(StreamTable.depth, 350, heads[3].interpolate(heads[4], 0.5) * mounting)
        assertMounted(StreamTable.depth)
    }

    @Test
    fun aFrameFromBeforeAllHeadPosesGivesNone() {
        repeat(200) { head(it) }
        mountings.camera(StreamTable.depth, 350, random.transform())
        head(199)
        assertEquals(emptyMap(), found())
    }

    @Test
    fun theSameHeadPoseTwiceDoesNoHarm() {
        head(0)
        head(0)
        mountings.camera(StreamTable.depth, 0, heads[0] * mounting)
        assertMounted(StreamTable.depth)
    }

    @Test
    fun posesFromBeforeALossAreNotInterpolated() {
        head(0)
        mountings.camera(StreamTable.color, 40, random.transform())
        mountings.headLost()
        head(1)
        mountings.camera(StreamTable.depth, 40, random.transform())
        head(2)
        assertEquals(emptyMap(), found())
    }

    @Test
    fun aMountingOutlivesALossOfTheHead() {
        head(0)
        mountings.camera(StreamTable.depth, 0, heads[0] * mounting)
        mountings.headLost()
        assertMounted(StreamTable.depth)
    }

    @Test
    fun whatIsForgottenIsNotComposed() {
        head(0)
        for (stream in listOf(StreamTable.depth, StreamTable.color)) mountings.camera(stream, 0, heads[0] * mounting)
        mountings.camera(StreamTable.color, 40, random.transform())
        mountings.forget(StreamTable.color)
        head(1)
        assertMounted(StreamTable.depth)
    }

    @Test
    fun theLatestFrameDecides() {
        head(0)
        mountings.camera(StreamTable.depth, 0, Transform(Vector3(9.0, 9.0, 9.0), heads[0].rotation))
        mountings.camera(StreamTable.depth, 0, heads[0] * mounting)
        assertMounted(StreamTable.depth)
    }

    private fun head(number: Int) = mountings.head(number * 100L, heads[number])

    private fun found(): Map<StreamSpec, Transform> = buildMap { mountings.forEach { spec, it -> put(spec, it) } }

    private fun assertMounted(stream: StreamSpec) {
        assertEquals(setOf(stream), found().keys)
        assertMatrix(mounting.toMatrix(), found().getValue(stream).toMatrix())
    }
}
