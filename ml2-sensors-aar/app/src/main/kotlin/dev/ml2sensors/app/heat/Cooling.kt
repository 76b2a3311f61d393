package dev.ml2sensors.app.heat

import dev.ml2sensors.source.Thermal
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * Which cameras rest while the headset is hot: from [Thermal.SEVERE] on RGB, whose images are the largest and are
 * compressed besides, and from [Thermal.CRITICAL] on every camera. They go on when it is [Thermal.LIGHT] or cooler, so
 * that none goes on and off all the time. Poses, inertial units and whatever else is small never rest.
 *
 * Chosen without a measurement on a headset.
 */
internal object Cooling {
    private val rgb = setOf(StreamTable.color, StreamTable.mixedReality)

    /** Where [stream] begins to rest; null where it never does. */
    fun limit(stream: StreamSpec): Thermal? = when {
        stream.modes.isEmpty() -> null
        stream in rgb -> Thermal.SEVERE
        else -> Thermal.CRITICAL
    }

    /** Whether what rests goes on. */
    fun isOver(thermal: Thermal?): Boolean = thermal == null || thermal <= Thermal.LIGHT
}
