package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow

/**
 * The streams of one interface of the platform: the vendor's SDK, OpenXR, Camera2, SensorManager, or a simulation of
 * one. A [Headset] is made of several.
 *
 * @property backend its name in the stream table, such as `sdk` or `openxr`.
 * @property streams all that it knows, whether or not they can run now.
 */
internal interface SensorSource : AutoCloseable {
    val backend: String
    val streams: Set<StreamSpec>

    /** As [Headset.negotiate], for one of [streams]. */
    fun negotiate(stream: StreamSpec, requested: StreamValues): Answer

    /** As [Headset.samples], for one of [streams]. */
    fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample>

    /** Releases its sensors at once, while the app is in the background. Flows continue and deliver nothing. */
    fun pause() {}

    /** Opens its sensors again; a flow whose sensor cannot be opened fails. */
    fun resume() {}
}
