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
    private var previousHead: Timed? = null
    private var latestHead: Timed? = null

    fun forEach(action: (StreamSpec, Transform) -> Unit) {
        mountings.forEach(action)
    }

    fun head(
        captureNanos: Long,
        pose: Transform,
    ) {
        previousHead = latestHead
        latestHead = Timed(captureNanos, pose)
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
        previousHead = null
        latestHead = null
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
        val from = previousHead ?: return false
        val to = latestHead ?: return false
        if (frame.captureNanos !in from.captureNanos..to.captureNanos) return false
        val span = (to.captureNanos - from.captureNanos).toDouble()
        val head = from.pose.interpolate(to.pose, (frame.captureNanos - from.captureNanos) / span)
        mountings[spec] = head.inverse() * frame.pose
        return true
    }
}
