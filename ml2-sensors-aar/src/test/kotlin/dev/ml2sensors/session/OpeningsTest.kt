package dev.ml2sensors.session

import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.ProtocolException
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNull

/** The vectors of malformed frames and a fuzz target show the rest: here are numbers that wrap, limits together, and order between lanes. */
class OpeningsTest {
    private val delivered = ArrayList<Frame>()
    private val closed = HashSet<Int>()
    private val discarded = ArrayList<Frame>()
    private val openings = Openings(
        { _, it -> it.header.channel !in closed && delivered.add(it) },
        { _, it -> discarded += it },
    )

    init {
        val kinds = listOf(Open.SUBSCRIPTION, Open.SUBSCRIPTION, Open.CLIENT, Open.SERVICE)
        kinds.forEachIndexed { index, kind -> openings.asks(Open(index + 1, kind)) }
    }

    @Test
    fun aFrameBeforeOpenedDecidesOnTheLane() {
        openings.received("ros", frame(FrameKind.MESSAGE, SMALL, 0))
        assertRefused { openings.opened(Opened(SMALL, "opened", lane = "bulk_1")) }
        assertRefused { openings.opened(Opened(SMALL, "refused", reason = "no")) }
        assertRefused { openings.received("bulk_1", frame(FrameKind.MESSAGE, SMALL, 1)) }
        openings.opened(Opened(SMALL, "opened", lane = "ros"))
        assertEquals(1, delivered.size)
    }

    @Test
    fun messagesThatAreTakenMakeRoomForOthers() {
        for (number in listOf(-1, 0)) openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, number))
        assertRefused { openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, 1)) }
        openings.taken(LARGE, -1)
        openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, 2))
        assertRefused { openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, 3)) }
        openings.taken(LARGE, 2)
        for (number in 4..5) openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, number))
        assertEquals(listOf(-1, 0, 2, 4, 5), delivered.map { it.header.sequence })
    }

    @Test
    fun aMessageThatTheAppDoesNotTakeAnyMoreIsLate() {
        closed += SMALL
        openings.received("ros", frame(FrameKind.MESSAGE, SMALL, 0))
        assertEquals(listOf(0, 1), listOf(delivered.size, discarded.size))
        assertEquals(1, openings.late)
    }

    @Test
    fun whatALaterMessageHasLeftBehindIsNotTakenAgain() {
        for (number in listOf(-1, 0)) openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, number))
        assertEquals(listOf(true, false, false), listOf(0, -1, 0).map { openings.taken(LARGE, it) })
        openings.received("bulk_1", frame(FrameKind.MESSAGE, LARGE, 1))
        assertEquals(true, openings.taken(LARGE, 1))
    }

    @Test
    fun theNumbersOfASessionGoOnAfterThoseReceivedBefore() {
        openings.asks(Open(10, Open.SUBSCRIPTION, received = 0x8000_0000))
        openings.asks(Open(11, Open.SUBSCRIPTION, received = 1))
        val refused = assertFailsWith<ProtocolException> { openings.received("ros", frame(FrameKind.MESSAGE, 11, 0)) }
        assertEquals(ErrorCode.MALFORMED, refused.code)
        for (id in 10..11) openings.received("ros", frame(FrameKind.MESSAGE, id, if (id == 10) Int.MIN_VALUE else 1))
        assertEquals(2, delivered.size)
    }

    @Test
    fun messagesOf128MebibytesTogetherAreUnderWayAtMost() {
        val body = PAYLOAD.copyOf(FrameKind.MESSAGE.maxLength)
        for (id in 10..14) openings.asks(Open(id, Open.SUBSCRIPTION))
        for (number in 0..7) openings.received("bulk_1", frame(FrameKind.MESSAGE, 10 + number / 2, number, body))
        assertRefused { openings.received("bulk_1", frame(FrameKind.MESSAGE, 14, 0)) }
    }

    @Test
    fun sixtyFourRequestsOfAllServicesAreUnderWayAtMost() {
        for (id in 10..13) openings.asks(Open(id, Open.SERVICE))
        val services = listOf(SERVICE) + (10..13)
        val answers = services.flatMap { id ->
            (0..15).map { openings.received("ros", frame(FrameKind.REQUEST, id, it)) }
        }
        assertEquals(List(64) { null } + List(16) { "busy" }, answers.map { it?.code })
        openings.answered(SERVICE, 3)
        assertNull(openings.received("ros", frame(FrameKind.REQUEST, 13, 99)))
    }

    @Test
    fun aRequestIsAnsweredOnce() {
        for (number in listOf(-1, 1)) openings.asks(CLIENT, number)
        repeat(2) { openings.received("ros", frame(FrameKind.RESPONSE, CLIENT, -1)) }
        openings.received("ros", frame(FrameKind.RESPONSE, CLIENT, 0)) // a gap in the numbers
        assertEquals(1, delivered.size)
        assertEquals(2, openings.late)
        assertRefused { openings.received("ros", frame(FrameKind.RESPONSE, CLIENT, 2)) }
    }

    private fun frame(kind: FrameKind, id: Int, number: Int, body: ByteArray = PAYLOAD) =
        Frame(kind, FrameHeader(kind.code, body.size, id, number, captureNanos = 1), body)

    private fun assertRefused(block: () -> Unit) {
        assertEquals(ErrorCode.UNEXPECTED, assertFailsWith<ProtocolException> { block() }.code)
    }

    private companion object {
        const val SMALL = 1
        const val LARGE = 2
        const val CLIENT = 3
        const val SERVICE = 4
        val PAYLOAD = byteArrayOf(0, 1, 0, 0, 0)
    }
}
