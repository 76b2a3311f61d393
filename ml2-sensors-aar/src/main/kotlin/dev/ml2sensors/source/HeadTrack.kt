package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.interpolate
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.wire.Event

/**
 * The head's latest poses and losses: where it was at an instant, if that can be known. Used by one thread at a time.
 *
 * @param report takes what users have to know of the tracking.
 */
internal class HeadTrack(private val report: (Event) -> Unit) {
    private val samples = ArrayDeque<PoseSample>()

    /** Whether poses before the oldest of [samples] are lost. */
    private var hasLosses = false

    /** Null before the head was ever tracked. */
    private var isTracked: Boolean? = null

    fun add(sample: PoseSample) {
        tell(sample)
        if (sample.isInNewWorld) clear()
        samples.addLast(sample)
        if (samples.size > KEPT_SAMPLES) {
            samples.removeFirst()
            hasLosses = true
        }
    }

    /** What follows has no connection to what was. */
    fun clear() {
        samples.clear()
        hasLosses = false
    }

    /** Poses are missing before those that follow. */
    fun lose() {
        samples.clear()
        hasLosses = true
    }

    /** Where the head was; known only between two samples that are both tracked. */
    fun at(nanos: Long): HeadAt {
        val next = samples.indexOfFirst { it.captureNanos >= nanos }
        val to = samples.getOrNull(next) ?: return HeadAt.NotYetKnown
        val end = to.pose ?: return HeadAt.NotTracked
        if (to.captureNanos == nanos) return HeadAt.Tracked(end)
        val from = samples.getOrNull(next - 1) ?: return if (hasLosses) HeadAt.Lost else HeadAt.NotTracked
        val start = from.pose ?: return HeadAt.NotTracked
        val fraction = (nanos - from.captureNanos).toDouble() / (to.captureNanos - from.captureNanos)
        return HeadAt.Tracked(start.interpolate(end, fraction))
    }

    private fun tell(sample: PoseSample) {
        val was = isTracked
        val isNow = sample.pose != null
        if (was != null || isNow) isTracked = isNow
        if (was == null) return
        if (sample.isInNewWorld) {
            report(Event(Event.TRACKING_NEW_SESSION, "head tracking begins anew: the world is another one"))
        }
        if (was && !isNow) {
            report(Event(Event.TRACKING_LOST, "head tracking is lost: no transforms until it is recovered"))
        }
        if (!was && isNow) report(Event(Event.TRACKING_RECOVERED, "head tracking is recovered"))
    }

    private companion object {
        /** About a second of them: frames are delivered later than the head poses of their time. */
        const val KEPT_SAMPLES = 64
    }
}

/** What a [HeadTrack] knows of an instant. */
internal sealed interface HeadAt {
    class Tracked(val pose: Transform) : HeadAt

    /** It was tracked perhaps, but the poses of then are lost. */
    data object Lost : HeadAt

    /** Nor will it become known that it was. */
    data object NotTracked : HeadAt

    /** The sample after it is yet to come. */
    data object NotYetKnown : HeadAt
}
