package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.test.runCurrent
import kotlinx.coroutines.test.runTest
import kotlinx.coroutines.withContext
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class TrackingEventsTest {
    private val events = mutableListOf<Event>()
    private val tracking = TrackingEvents(events::add)

    @Test
    fun theHeadIsNotLostBeforeItWasEverTracked() {
        tracking.add(PoseSample(0, null, isInNewWorld = true))
        tracking.add(PoseSample(100, Transform.IDENTITY))
        assertEquals(emptyList(), events)
    }

    @Test
    fun aNewWorldWhileTheHeadIsLostIsReportedBesideItsRecovery() {
        tracking.add(PoseSample(0, Transform.IDENTITY))
        tracking.add(PoseSample(100, null))
        tracking.add(PoseSample(200, Transform.IDENTITY, isInNewWorld = true))
        assertEquals(
            listOf(Event.TRACKING_LOST, Event.TRACKING_NEW_SESSION, Event.TRACKING_RECOVERED),
            events.map { it.event },
        )
    }

    @Test
    fun aWatchThatEndsBeforeItsTurnLetsNoOtherComeBesideTheOneBefore() = runTest {
        val isLetGo = CompletableDeferred<Unit>()
        var begun = 0
        val headset = object : Headset by FakeHeadset() {
            override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
                begun++
                withContext(NonCancellable) { isLetGo.await() }
            }
        }
        val watch = HeadWatch(headset, backgroundScope, tracking, Conditions(events::add))
        watch.begin(setOf(StreamTable.headPose))
        runCurrent()
        repeat(2) {
            watch.end()
            watch.begin(setOf(StreamTable.headPose))
        }
        runCurrent()
        assertEquals(1, begun)
        isLetGo.complete(Unit)
        runCurrent()
        assertEquals(2, begun)
    }
}
