package dev.ml2sensors.stream

import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.angleTo
import dev.ml2sensors.message.distanceTo
import dev.ml2sensors.message.normalized
import java.util.Locale

/**
 * Estimates the pose of one camera on the head from its latest [WINDOW] frames: the median of each component, which a
 * few wrong frames do not move. The estimate is stable once nine in ten frames lie within [SPREAD_METRES] and
 * [SPREAD_RADIANS] of it. It then changes only when a new stable median differs by more than that. Used by one thread
 * at a time.
 */
internal class SensorMounting {
    private val frames = ArrayDeque<Transform>()

    /** The present estimate, from the first frame on. */
    var latest: Transform = Transform.IDENTITY
        private set

    /** The stable estimate, null while there is none. */
    var stable: Transform? = null
        private set

    /** Adds the mounting of one frame; returns the residual of the frames if [stable] changes because of it. */
    fun add(frame: Transform): Residual? {
        frames.addLast(frame)
        if (frames.size > WINDOW) frames.removeFirst()
        val median = frames.median()
        latest = stable ?: median
        if (frames.size < WINDOW || stable?.isNear(median) == true) return null
        val residual = Residual.of(frames, median)
        if (!residual.isSmall) return null
        stable = median
        latest = median
        return residual
    }

    private fun Transform.isNear(other: Transform) =
        distanceTo(other) <= SPREAD_METRES && rotation.angleTo(other.rotation) <= SPREAD_RADIANS

    /** The distances of frames from a rigid mounting, in metres and radians, ascending. */
    class Residual private constructor(private val metres: List<Double>, private val radians: List<Double>) {
        val isSmall: Boolean get() = ninth(metres) <= SPREAD_METRES && ninth(radians) <= SPREAD_RADIANS

        /** Medians and maxima. */
        override fun toString(): String = String.format(
            Locale.ROOT,
            "median %.3f mm and %.4f deg, at most %.3f mm and %.4f deg",
            metres[metres.size / 2] * 1000,
            Math.toDegrees(radians[radians.size / 2]),
            metres.last() * 1000,
            Math.toDegrees(radians.last()),
        )

        private fun ninth(sorted: List<Double>) = sorted[sorted.size * 9 / 10 - 1]

        companion object {
            fun of(frames: List<Transform>, mounting: Transform): Residual = Residual(
                frames.map { it.distanceTo(mounting) }.sorted(),
                frames.map { it.rotation.angleTo(mounting.rotation) }.sorted(),
            )
        }
    }

    companion object {
        /** One second of a camera. */
        const val WINDOW = 30
        const val SPREAD_METRES = 0.001
        val SPREAD_RADIANS = Math.toRadians(0.1)
    }
}

private fun List<Transform>.median(): Transform {
    fun of(component: (Transform) -> Double) = map(component).sorted().let { (it[(size - 1) / 2] + it[size / 2]) / 2 }
    val reference = first().rotation

    fun ofRotation(component: (Quaternion) -> Double) =
        of { if (it.rotation.dot(reference) < 0) -component(it.rotation) else component(it.rotation) }
    return Transform(
        Vector3(of { it.translation.x }, of { it.translation.y }, of { it.translation.z }),
        Quaternion(
            ofRotation { it.x },
            ofRotation { it.y },
            ofRotation { it.z },
            ofRotation { it.w },
        ).normalized(),
    )
}

private fun Quaternion.dot(other: Quaternion) = x * other.x + y * other.y + z * other.z + w * other.w
