package dev.ml2sensors.stream

import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
import kotlinx.coroutines.launch
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock

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

/**
 * Reports changes of head tracking to [events] while poses are sent without `tf`, which reports them itself. Used by one
 * thread at a time.
 */
internal class HeadWatch(
    private val headset: Headset,
    private val scope: CoroutineScope,
    private val events: TrackingEvents,
    private val conditions: Conditions,
) {
    private var job: Job? = null

    /** Held by one watch at a time, until the headset has let go of the poses. */
    private val watching = Mutex()

    /** Begins if [running] have poses in the world frame, and no `tf`; [end] was called before. */
    fun begin(running: Set<StreamSpec>) {
        val hasPoses = running.any { spec -> spec.topics.any { "/Pose" in it.type } }
        if (!hasPoses || StreamTable.tf in running) return
        job = scope.launch { watching.withLock { watch() } }
    }

    fun end() {
        job?.cancel()
    }

    private suspend fun watch() {
        val head = StreamTable.headPose
        val values = headset.negotiate(head, head.defaultValues()).acceptedValues ?: return
        StreamSupervisor.of(head, headset) {
        }.run({ conditions.watch(Conditions.TRACKING, headset.samples(head, values)) }) { samples ->
            samples.collect { if (it is PoseSample) events.add(it) }
        }
    }
}

/**
 * Counts images of [spec] without a pose, and reports their number as an event: when it is [FIRST], whenever it has
 * doubled since, and at the end. Used by one thread at a time.
 */
internal class PoselessImages(private val spec: StreamSpec, private val report: (Event) -> Unit) {
    private var count = 0L
    private var reported = 0L

    fun add(hasPose: Boolean) {
        if (hasPose) return
        count++
        if (count >= maxOf(FIRST, 2 * reported)) reportCount()
    }

    /** Reports the number if it has grown since the last report. */
    fun end() {
        if (count > reported) reportCount()
    }

    private fun reportCount() {
        reported = count
        report(Event(Event.IMAGES_WITHOUT_POSE, "$count images of $spec had no pose since the stream began"))
    }

    private companion object {
        /** A second of images. The first images of a stream may come before the tracker is ready. */
        const val FIRST = 30L
    }
}
