package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec

/** A headset refused [stream]; [answer] has the reason. */
internal class RefusedException(val stream: StreamSpec, val answer: Answer.Refused) :
    SourceException("$stream: ${answer.reason}")
