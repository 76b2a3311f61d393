package dev.ml2sensors.session

import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import java.io.DataInputStream
import java.io.EOFException
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** A frame as a receiver sees it, read and written by the table of PROTOCOL.md and no code of the library. */
internal class HostFrame(
    val lane: String,
    val kind: Int,
    val channel: Int = 0,
    val sequence: Long = 0,
    val captureNanos: Long = 0,
    val body: ByteArray = ByteArray(0),
) {
    val json: JsonObject get() = Json.parseToJsonElement(body.decodeToString()).jsonObject

    override fun toString() = "$lane: $kind ${if (kind == DATA) "of $channel" else body.decodeToString().take(200)}"

    companion object {
        const val HELLO = 1
        const val WELCOME = 2
        const val JOIN = 3
        const val JOINED = 4
        const val CONFIGURE = 5
        const val CONFIGURED = 6
        const val CHANNEL = 7
        const val CHANNEL_END = 8
        const val START = 9
        const val DATA = 16
        const val TIME_REQUEST = 32
        const val TIME_REPLY = 33
        const val LINK_TEST = 40
        const val FILLER = 41
        const val STATUS = 48
        const val PING = 49
        const val PONG = 50
        const val ERROR = 51
        const val BYE = 52
        const val EVENT = 53
        const val OPEN = 96
        const val OPENED = 97
        const val CLOSE = 98
        const val CLOSED = 99
        const val TAKEN = 112
        const val MESSAGE = 128
        const val POSE = 129
        const val REQUEST = 130
        const val RESPONSE = 131
        const val FAILURE = 132

        /** In place of a kind: the connection has ended. */
        const val END = -1
        private const val HEADER_BYTES = 32

        /** The next frame of [input], null at its end. */
        fun read(lane: String, input: DataInputStream): HostFrame? {
            val bytes = ByteArray(HEADER_BYTES)
            val first = input.read()
            if (first < 0) return null
            bytes[0] = first.toByte()
            input.readFully(bytes, 1, HEADER_BYTES - 1)
            val header = ByteBuffer.wrap(bytes).order(ByteOrder.LITTLE_ENDIAN)
            check(header.getShort(0).toInt() == 0x324D && header.get(2).toInt() == 1) {
                "no header: ${bytes.toHexString()}"
            }
            val body = ByteArray(header.getInt(12))
            try {
                input.readFully(body)
            } catch (e: EOFException) {
                throw EOFException("$lane ends inside a frame").initCause(e)
            }
            val channel = header.getShort(6).toInt() and 0xFFFF
            val sequence = header.getInt(8).toLong() and 0xFFFF_FFFF
            return HostFrame(lane, header.get(3).toUByte().toInt(), channel, sequence, header.getLong(16), body)
        }

        fun bytes(
            kind: Int,
            body: ByteArray = ByteArray(0),
            channel: Int = 0,
            sequence: Int = 0,
            captureNanos: Long = 0,
        ): ByteArray =
            ByteBuffer.allocate(HEADER_BYTES + body.size).order(ByteOrder.LITTLE_ENDIAN)
                .putShort(0x324D).put(1).put(kind.toByte())
                .putShort(0).putShort(channel.toShort()).putInt(sequence).putInt(body.size)
                .putLong(captureNanos).putLong(0)
                .put(body)
                .array()
    }
}
