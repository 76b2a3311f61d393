package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flowOf
import kotlinx.coroutines.flow.map
import kotlinx.coroutines.flow.toList
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

class CameraTest {
    private val source = OneCamera()
    private val headset = SensorHeadset(Headset.Identity("id", "name"), { 0L }, listOf(source))

    @Test
    fun framesAreTheImagesOfTheFirstModeUnlessAnotherIsAskedFor() = runTest {
        assertEquals(listOf(7L), headset.camera(WorldCamera.LEFT).frames().map { it.frameNumber }.toList())
        val lowExposure = StreamTable.worldLeft.defaultValues().copy(stream = 1)
        headset.camera(WorldCamera.LEFT).frames(lowExposure).toList()
        assertEquals(listOf(StreamTable.worldLeft.defaultValues(), lowExposure), source.collected)
    }

    @Test
    fun valuesThatAreAdjustedAreTakenAsTheyCome() = runTest {
        val adjusted = StreamTable.worldLeft.defaultValues().copy(rateHz = 10)
        source.answer = Answer.Adjusted(adjusted, "slow")
        headset.camera(WorldCamera.LEFT).frames().toList()
        assertEquals(listOf(adjusted), source.collected)
    }

    @Test
    fun aRefusalFailsTheCollectionAndNamesThePermission() = runTest {
        source.answer = Answer.Refused("not granted", "CAMERA")
        val refusal = assertFailsWith<RefusedException> { headset.camera(WorldCamera.LEFT).frames().toList() }
        assertEquals("CAMERA", refusal.answer.permission)
        assertEquals("world_left: not granted", refusal.message)
    }

    @Test
    fun whatIsNoCameraIsAMistakeOfTheCaller() {
        assertFailsWith<IllegalArgumentException> { headset.camera(StreamTable.gyroLeft) }
    }

    private class OneCamera : SensorSource {
        var answer: Answer? = null
        val collected = mutableListOf<StreamValues>()
        override val backend = "sdk"
        override val streams = setOf(StreamTable.worldLeft)

        override fun negotiate(stream: StreamSpec, requested: StreamValues) = answer ?: Answer.Applied(requested)

        override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
            collected += values
            val image = ImageSample(1, 7, 1, 1, 1, null, null, CaptureSettings(), emptyList()) {}
            return flowOf(LostSamples(0, 1, DropReason.SOURCE_LATE), image)
        }

        override fun close() = Unit
    }
}
