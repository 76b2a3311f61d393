package dev.ml2sensors.cdr

import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlin.test.assertContentEquals

/** Bytes from a listing such as `2a 00  # 42`: spaces do not count, nor does what follows a `#` on its line. */
internal fun hex(listing: String): ByteArray = listing
    .lines()
    .joinToString("") { it.substringBefore('#') }
    .filterNot(Char::isWhitespace)
    .hexToByteArray()

/** Asserts that [message] becomes the bytes of [listing], and that these become the same bytes again. */
@OptIn(ExperimentalSerializationApi::class)
internal fun <T> assertCdr(serializer: KSerializer<T>, message: T, listing: String): T {
    val expected = hex(listing)
    assertContentEquals(expected, Cdr.encodeToByteArray(serializer, message))
    val decoded = Cdr.decodeFromByteArray(serializer, expected)
    assertContentEquals(expected, Cdr.encodeToByteArray(serializer, decoded))
    return decoded
}
