package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import java.io.IOException

/** A source cannot deliver, or no longer, because of the device, the platform or the user. Ends its flow. */
public open class SourceException(message: String, cause: Throwable? = null) : IOException(message, cause) {
    /** The Android permission to request for it, null when that is not what is missing. */
    public open val permission: String? get() = null
}

/** A headset refused [stream]; [answer] has the reason. */
internal class RefusedException(val stream: StreamSpec, val answer: Answer.Refused) :
    SourceException("$stream: ${answer.reason}")
