package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow
import java.io.IOException

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

/** A source cannot deliver, or no longer, because of the device, the platform or the user. Ends its flow. */
public open class SourceException(message: String, cause: Throwable? = null) : IOException(message, cause) {
    /** The Android permission to request for it, null when that is not what is missing. */
    public open val permission: String? get() = null
}

/** A headset refused [stream]; [answer] has the reason. */
internal class RefusedException(val stream: StreamSpec, val answer: Answer.Refused) :
    SourceException("$stream: ${answer.reason}")
