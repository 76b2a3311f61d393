package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.wire.Event
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
}
