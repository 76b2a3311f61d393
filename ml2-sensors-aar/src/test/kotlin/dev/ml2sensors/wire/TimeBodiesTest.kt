package dev.ml2sensors.wire

import dev.ml2sensors.cdr.hex
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.ByteOrder
import kotlin.test.assertContentEquals
import kotlin.test.assertEquals
import kotlin.test.assertNotNull
import kotlin.test.assertNull

class TimeBodiesTest {
    @Test
    fun requestsAreTheirTime() {
        assertContentEquals(hex("08 07 06 05 04 03 02 01"), TimeBodies.request(0x0102030405060708))
    }

    @Test
    fun exchangesBoundTheOffsetAndGiveTheRoundTrip() {
        val exchange = assertNotNull(TimeBodies.exchange(100, reply(100, 1_130, 1_140), t4 = 170))
        assertEquals(1_030, exchange.mostOffsetNanos) // of 1000 ns; 30 ns out, 10 ns at the host, 30 ns back
        assertEquals(970, exchange.leastOffsetNanos)
        assertEquals(60, exchange.roundTripNanos)
    }

    @Test
    fun repliesThatAnswerAnotherRequestAreDiscarded() {
        assertNull(TimeBodies.exchange(100, reply(99, 1_130, 1_140), t4 = 170))
    }

    @Test
    fun impossibleRepliesAreDiscarded() {
        assertNull(TimeBodies.exchange(100, reply(100, 1_140, 1_139), t4 = 170), "answered before it arrived")
        assertNull(TimeBodies.exchange(100, reply(100, 1_130, 1_201), t4 = 170), "longer at the host than away")
        assertNull(TimeBodies.exchange(100, reply(100, Long.MIN_VALUE, Long.MAX_VALUE), t4 = 170), "ages there")
        assertNull(TimeBodies.exchange(100, reply(100, Long.MAX_VALUE, Long.MIN_VALUE), t4 = 170), "ages before")
    }

    private fun reply(t1: Long, t2: Long, t3: Long): ByteArray =
        ByteBuffer.allocate(24).order(ByteOrder.LITTLE_ENDIAN).putLong(t1).putLong(t2).putLong(t3).array()
}
