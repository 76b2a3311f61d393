package dev.ml2sensors.source

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.interpolate

/** Keeps the latest poses of the head and interpolates between them. Used by one thread at a time. */
internal class HeadTrack {
    private val samples = ArrayDeque<PoseSample>()

    /** True if poses before the oldest of [samples] are lost. */
    private var hasLosses = false

    /** Adds the next pose; a pose in a new world makes the earlier ones unusable. */
    fun add(sample: PoseSample) {
        if (sample.isInNewWorld) clear()
        samples.addLast(sample)
        if (samples.size > MAX_SAMPLES) {
            samples.removeFirst()
            hasLosses = true
        }
    }

    /** Forgets all poses: those that follow are not connected to them. */
    fun clear() {
        samples.clear()
        hasLosses = false
    }

    /** Marks that poses are missing before those that follow. */
    fun lose() {
        samples.clear()
        hasLosses = true
    }

    /** Returns where the head was at [nanos]; known only between two samples that are both tracked. */
    fun at(nanos: Long): HeadPose {
        val next = samples.indexOfFirst { it.captureNanos >= nanos }
        val to = samples.getOrNull(next) ?: return HeadPose.NotYetKnown
        val end = to.pose ?: return HeadPose.NotTracked
        if (to.captureNanos == nanos) return HeadPose.Tracked(end)
        val from = samples.getOrNull(next - 1) ?: return if (hasLosses) HeadPose.Lost else HeadPose.NotTracked
        val start = from.pose ?: return HeadPose.NotTracked
        val interval = to.captureNanos - from.captureNanos
        val fraction = (nanos - from.captureNanos).toDouble() / interval
        return HeadPose.Tracked(start.interpolate(end, fraction), isBridged = interval > LONGEST_INTERVAL_NANOS)
    }

    companion object {
        /**
         * The most missing poses that are interpolated over: the head moves nearly straight within 67 ms. After a
         * longer gap the caller calls [lose] or [clear].
         */
        const val MAX_BRIDGED: Int = 3

        /** Between two poses at 60 Hz; in a longer interval, at least one is missing. */
        private const val LONGEST_INTERVAL_NANOS = 25_000_000L

        /** About one second at 60 Hz: frames arrive later than the head poses of their capture. */
        private const val MAX_SAMPLES = 64
    }
}

/** The result of [HeadTrack.at]. */
internal sealed interface HeadPose {
    /**
     * The [pose] of the head in the world frame, in body axes. It [isBridged] if poses are missing around it: a turning
     * head may then be a degree off.
     */
    class Tracked(val pose: Transform, val isBridged: Boolean = false) : HeadPose

    /** The poses around that instant were lost, so it is not known whether the head was tracked. */
    data object Lost : HeadPose

    /** The head was not tracked, or no pose of that instant will arrive any more. */
    data object NotTracked : HeadPose

    /** The next pose after that instant has not arrived yet. */
    data object NotYetKnown : HeadPose
}
