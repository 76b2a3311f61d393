package dev.ml2sensors.app.thermal

import dev.ml2sensors.source.Thermal
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * Decides which cameras are paused while the headset is hot. From [Thermal.SEVERE] on it pauses RGB, whose images are
 * the largest and need compression. From [Thermal.CRITICAL] on it pauses every camera. Cameras resume at [Thermal.LIGHT]
 * or cooler, so that they do not switch all the time. Poses, inertial units and other small streams are never paused.
 *
 * The limits were chosen without a measurement on a headset.
 */
internal object ThermalPolicy {
    private val rgb = setOf(StreamTable.color, StreamTable.mixedReality)

    /** Returns the status from which [stream] is paused, or null if it never is. */
    fun limit(stream: StreamSpec): Thermal? = when {
        !stream.isCamera -> null
        stream in rgb -> Thermal.SEVERE
        else -> Thermal.CRITICAL
    }

    /** Returns true if paused cameras may resume. */
    fun mayResume(thermal: Thermal?): Boolean = thermal == null || thermal <= Thermal.LIGHT
}
