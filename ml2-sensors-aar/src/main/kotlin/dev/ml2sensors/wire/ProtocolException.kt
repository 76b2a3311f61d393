package dev.ml2sensors.wire

import java.io.IOException

/** The peer violated PROTOCOL.md, or, if [isPeers], its ERROR says that we did. Ends the connection. */
internal class ProtocolException(val code: ErrorCode, message: String, val isPeers: Boolean = false) :
    IOException(message)

/** The codes of ERROR bodies. */
internal enum class ErrorCode(val wireName: String) {
    VERSION("version"),
    BUSY("busy"),
    MALFORMED("malformed"),
    TOO_LARGE("too_large"),
    UNEXPECTED("unexpected"),
    TICKET("ticket"),
    CHANNEL("channel"),
    TIMEOUT("timeout"),
    SOURCE("source"),
    PAIRING("pairing"),
}
