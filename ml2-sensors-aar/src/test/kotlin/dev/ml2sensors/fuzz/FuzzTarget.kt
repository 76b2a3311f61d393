package dev.ml2sensors.fuzz

import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.cdr.CdrDecodingException
import dev.ml2sensors.cdr.WideStringSerializer
import dev.ml2sensors.conformance.CdrVector
import dev.ml2sensors.conformance.MESSAGE_SERIALIZERS
import dev.ml2sensors.conformance.Vector
import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.session.Openings
import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.Configure
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.Failure
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.FrameReader
import dev.ml2sensors.wire.Joined
import dev.ml2sensors.wire.LinkTestBody
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.PairChallenge
import dev.ml2sensors.wire.Paired
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.RosLanes
import dev.ml2sensors.wire.Start
import dev.ml2sensors.wire.TimeBodies
import dev.ml2sensors.wire.Welcome
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import kotlinx.serialization.builtins.ListSerializer
import java.io.EOFException
import java.nio.ByteBuffer
import java.nio.channels.Channels
import kotlin.random.Random
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertTrue

/** A reader of untrusted bytes: anything may be refused in the way that is documented, nothing else may happen. */
@OptIn(ExperimentalSerializationApi::class)
internal enum class FuzzTarget {
    FRAMES {
        override fun seeds() = Vector.loadAll("wire").map { it.bytes }

        override fun read(data: ByteArray) {
            val reader = FrameReader(Channels.newChannel(data.inputStream()))
            reader.maxMessageBytes = FrameKind.MESSAGE.maxLength
            try {
                while (true) {
                    val frame = reader.next(FrameKind.entries.toSet()) ?: break
                    assertEquals(frame.header.length, frame.body.size)
                    if (frame.kind == FrameKind.TIME_REPLY) TimeBodies.exchange(1, frame.body, 2)
                }
            } catch (_: ProtocolException) {
            } catch (_: EOFException) {
            }
        }
    },

    BODIES {
        override fun seeds() = Vector.loadAll("wire").map { it.bytes.drop(HEADER_BYTES).toByteArray() }

        override fun read(data: ByteArray) {
            body<Welcome>(data)
            body<Joined>(data)
            body<Configure>(data)
            body<Start>(data)
            body<LinkTestBody>(data)
            body<ErrorBody>(data)
            body<Bye>(data)
            body<Opened>(data)
            body<Closed>(data)
            body<Failure>(data)
        }
    },

    /** Frames that the app is sent in the openings 1 to 4; the first byte chooses the lane. */
    OPENINGS {
        private val kinds = listOf(Open.SUBSCRIPTION, Open.SUBSCRIPTION, Open.CLIENT, Open.SERVICE, Open.TRANSFORM)

        override fun seeds() = Vector.loadAll("wire").filter { "ros" in it.case }.flatMap { case ->
            (0..1).map { byteArrayOf(it.toByte()) + case.bytes + case.bytes }
        }

        override fun read(data: ByteArray) {
            if (data.isEmpty()) return
            val lane = RosLanes.ALL[data[0].toUByte().toInt() % 2]
            var counted = 0L
            val openings = Openings({ _, _ -> counted++ >= 0 })
            kinds.forEachIndexed { index, kind -> openings.asks(Open(index + 1, kind)) }
            openings.asks(3, 7)
            val reader = FrameReader(Channels.newChannel(data.inputStream(1, data.size - 1)))
            reader.maxMessageBytes = RosLanes.maxMessageBytes(lane)
            try {
                var frames = 0L
                while (true) {
                    val frame = reader.next(FrameKind.entries.toSet()) ?: break
                    if (frame.kind == FrameKind.ERROR) continue
                    frames++
                    if (openings.received(lane, frame) != null) counted++
                    assertEquals(frames, counted + openings.late)
                }
            } catch (_: ProtocolException) {
            } catch (_: EOFException) {
            }
        }
    },

    /** Frames of openings in any order. Four bytes draw each, and what the app does before it. */
    ORDER {
        private val kinds = listOf(FrameKind.MESSAGE, FrameKind.POSE, FrameKind.REQUEST, FrameKind.RESPONSE)
        private val bodies = List(5) { byteArrayOf(0, 1, 0, 0, 0) } + byteArrayOf(1)

        override fun seeds() = List(8) { Random(it).nextBytes(DRAW_BYTES * 12) }

        override fun read(data: ByteArray) {
            val closed = HashSet<Int>()
            var delivered = 0L
            val openings =
                Openings({ _, it -> (it.header.channel !in closed).also { isTaken -> if (isTaken) delivered++ } })
            val uses = listOf(Open.SUBSCRIPTION, Open.SUBSCRIPTION, Open.CLIENT, Open.SERVICE)
            uses.forEachIndexed { index, kind -> openings.asks(Open(index + 1, kind)) }
            for (number in 0..<data.size / DRAW_BYTES) {
                val (kind, id, late, what) = List(DRAW_BYTES) { data[DRAW_BYTES * number + it].toUByte().toInt() }
                when (what % 32) {
                    0 -> closed += id % 5
                    in 1..6 -> openings.asks(3, number)
                    in 7..16 -> openings.taken(2, number)
                    in 17..20 -> openings.answered(4, number)
                }
                val body = bodies[what % bodies.size]
                val header = FrameHeader(kinds[kind % 4].code, body.size, id % 6, number - late % 4, captureNanos = 1)
                val before = delivered + openings.late
                val isAnswered = try {
                    openings.received(RosLanes.ALL[what / 32 % 2], Frame(kinds[kind % 4], header, body)) != null
                } catch (_: ProtocolException) {
                    true
                }
                assertEquals(if (isAnswered) 0 else 1, delivered + openings.late - before)
            }
        }
    },

    PAIRING {
        override fun seeds() = listOf(
            """{"nonce": "${"0123456789abcdef".repeat(4)}", "name": "desk", "software": "ml2-receiver 0.1.0"}""",
            """{"name": "desk", "port": 7755}""",
        ).map(String::toByteArray)

        override fun read(data: ByteArray) {
            body<PairChallenge>(data)
            body<Paired>(data)
        }
    },

    /** The first byte chooses the type. */
    MESSAGES {
        private val serializers = MESSAGE_SERIALIZERS.values.toList() + ListSerializer(WideStringSerializer)

        override fun seeds() = CdrVector.all.map { byteArrayOf(serializers.indexOf(it.serializer).toByte()) + it.bytes }

        override fun read(data: ByteArray) {
            if (data.isEmpty()) return
            val serializer = serializers[data[0].toUByte().toInt() % serializers.size]
            written(serializer, ByteBuffer.wrap(data).position(1))
        }

        /** A message that is read is the same after it was written and read again, as bytes: a number may be NaN. */
        private fun <T> written(serializer: KSerializer<T>, bytes: ByteBuffer) {
            val message = try {
                Cdr.decode(serializer, bytes, allowsTail = true)
            } catch (_: CdrDecodingException) {
                return
            }
            val written = Cdr.encodeToByteArray(serializer, message)
            assertTrue(written.size <= bytes.remaining())
            val again = Cdr.decodeFromByteArray(serializer, written)
            assertContentEquals(written, Cdr.encodeToByteArray(serializer, again))
        }
    },

    URI {
        override fun seeds() = listOf("192.168.1.5", "[fd00::7]").map { host ->
            "ml2s://$host:7756?fp=${"0123456789abcdef".repeat(4)}&token=${"0123456789abcdef".repeat(2)}".toByteArray()
        }

        override fun read(data: ByteArray) {
            val text = data.decodeToString()
            val uri = try {
                PairingUri.parse(text)
            } catch (_: IllegalArgumentException) {
                return
            }
            assertEquals("ml2s", text.substringBefore(':'))
            assertEquals(text.substringAfter("token="), uri.token)
        }
    }, ;

    abstract fun seeds(): List<ByteArray>

    /** Fails for what must not happen. */
    abstract fun read(data: ByteArray)

    /** A body that is taken is the same after it was written and read again. */
    protected inline fun <reified T> body(data: ByteArray) {
        val first = try {
            ControlJson.decode<T>(data)
        } catch (_: ProtocolException) {
            return
        }
        val written = ControlJson.encode(first)
        assertContentEquals(written, ControlJson.encode(ControlJson.decode<T>(written)))
    }

    private companion object {
        const val HEADER_BYTES = 32

        /** The bytes of the input that choose one frame of [ORDER]. */
        const val DRAW_BYTES = 4
    }
}
