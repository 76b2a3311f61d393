package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.interpolate
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.times
import dev.ml2sensors.table.StreamSpec

/**
 * Where the cameras sit on the head, each from its latest frame whose capture lies between two head poses. Used by one
 * thread at a time.
 */
internal class SensorMountings {
    private class Timed(
        val captureNanos: Long,
        val pose: Transform,
    )

    private val mountings = LinkedHashMap<StreamSpec, Transform>()
    private val waiting = HashMap<StreamSpec, Timed>()
    private val heads = ArrayDeque<Timed>()

    fun forEach(action: (StreamSpec, Transform) -> Unit) {
        mountings.forEach(action)
    }

    fun head(
        captureNanos: Long,
        pose: Transform,
    ) {
        heads.addLast(Timed(captureNanos, pose))
        if (heads.size > KEPT_HEADS) heads.removeFirst()
        waiting.entries.removeIf { (spec, frame) -> solve(spec, frame) || frame.captureNanos < captureNanos }
    }

    fun camera(
        spec: StreamSpec,
        captureNanos: Long,
        pose: Transform,
    ) {
        val frame = Timed(captureNanos, pose)
        if (!solve(spec, frame)) waiting[spec] = frame
    }

    /** Poses from before a loss are of another map. */
    fun headLost() {
        heads.clear()
        waiting.clear()
    }

    fun forget(spec: StreamSpec) {
        mountings.remove(spec)
        waiting.remove(spec)
    }

    private fun solve(
        spec: StreamSpec,
        frame: Timed,
    ): Boolean {
        val head = headAt(frame.captureNanos) ?: return false
        mountings[spec] = head.inverse() * frame.pose
        return true
    }

    private fun headAt(nanos: Long): Transform? {
        val next = heads.indexOfFirst { it.captureNanos >= nanos }
        val to = heads.getOrNull(next) ?: return null
        if (to.captureNanos == nanos) return to.pose
        val from = heads.getOrNull(next - 1) ?: return null
        val fraction = (nanos - from.captureNanos).toDouble() / (to.captureNanos - from.captureNanos)
        return from.pose.interpolate(to.pose, fraction)
    }

    private companion object {
        /** About a second of them: frames are delivered later than the head poses of their time. */
        const val KEPT_HEADS = 64
    }
}
