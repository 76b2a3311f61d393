package dev.ml2sensors.cdr

import kotlinx.serialization.SerializationException

/** The bytes at [offset], counted from the first byte of the encapsulation header, are not the message expected. */
internal class CdrDecodingException(expected: String, found: String, offset: Int, cause: Throwable? = null) :
    SerializationException("Expected $expected, but found $found at offset $offset", cause)
