package dev.ml2sensors.stream

import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.wire.Event

/** Reports changes of head tracking as events. Used by one thread at a time. */
internal class TrackingEvents(private val report: (Event) -> Unit) {
    /** Null before the head was ever tracked. */
    private var isTracked: Boolean? = null

    /** Adds the head's next [sample]. */
    fun add(sample: PoseSample) {
        val wasTracked = isTracked
        val isNow = sample.pose != null
        if (wasTracked != null || isNow) isTracked = isNow
        if (wasTracked == null) return
        if (sample.isInNewWorld) {
            report(
                Event(
                    Event.TRACKING_NEW_SESSION,
                    "head tracking has restarted with a new world origin: earlier poses no longer apply",
                ),
            )
        }
        if (wasTracked && !isNow) {
            report(Event(Event.TRACKING_LOST, "head tracking is lost: no transforms until it is recovered"))
        }
        if (!wasTracked && isNow) report(Event(Event.TRACKING_RECOVERED, "head tracking is recovered"))
    }
}
