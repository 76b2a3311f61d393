package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals

class ChannelCountersTest {
    private val counters = ChannelCounters()

    @Test
    fun sequenceNumbersCountFromZeroAndLeaveGapsForWhatASourceLost() {
        assertEquals(listOf(0, 1), List(2) { counters.nextSequence() })
        counters.countLost(3, DropReason.NO_BUFFER)
        assertEquals(5, counters.nextSequence())
        assertBooks(produced = 6, sent = 0, "no_buffer" to 3)
    }

    @Test
    fun sequenceNumbersAreModuloTwoToThe32() {
        counters.countLost(Int.MAX_VALUE, DropReason.SOURCE_LATE)
        assertEquals(Int.MAX_VALUE, counters.nextSequence())
        counters.countLost(Int.MAX_VALUE, DropReason.SOURCE_LATE)
        assertEquals(-1, counters.nextSequence())
        assertEquals(0, counters.nextSequence())
    }

    @Test
    fun onlyReasonsThatOccurredAreNamed() {
        repeat(4) { counters.nextSequence() }
        counters.countSent()
        counters.countDropped(DropReason.QUEUE_FULL)
        counters.countDropped(DropReason.ENCODER_BUSY)
        counters.countDropped(DropReason.CLOCK_STEP)
        assertBooks(produced = 4, sent = 1, "queue_full" to 1, "encoder_busy" to 1, "clock_step" to 1)
    }

    @Test
    fun whatWasSentButDidNotArriveWentDownWithTheLink() {
        repeat(10) { counters.nextSequence() }
        repeat(8) { counters.countSent() }
        repeat(2) { counters.countDropped(DropReason.QUEUE_FULL) }
        counters.reconcile(received = 5)
        assertBooks(produced = 10, sent = 5, "queue_full" to 2, "link_down" to 3)
        counters.reconcile(received = 5)
        assertBooks(produced = 10, sent = 5, "queue_full" to 2, "link_down" to 3)
    }

    @Test
    fun whatWasUnderWayWhenTheLinkBrokeMayHaveArrived() {
        repeat(5) { counters.nextSequence() }
        repeat(3) { counters.countSent() }
        repeat(2) { counters.countDropped(DropReason.LINK_DOWN) }
        counters.reconcile(received = 4)
        assertBooks(produced = 5, sent = 4, "link_down" to 1)
    }

    @Test
    fun aReceiverThatClaimsTooMuchCannotMakeDropsNegative() {
        repeat(5) { counters.nextSequence() }
        repeat(3) { counters.countSent() }
        repeat(2) { counters.countDropped(DropReason.LINK_DOWN) }
        counters.reconcile(received = Long.MAX_VALUE)
        assertBooks(produced = 5, sent = 5)
    }

    @Test
    fun booksBalanceWhateverHappens() {
        val random = Random(5)
        var open = 0
        repeat(2_000) {
            when (random.nextInt(5)) {
                0, 1 -> counters.nextSequence().also { open++ }
                2 -> if (open > 0) counters.countSent().also { open-- }
                3 -> if (open > 0) counters.countDropped(DropReason.entries.random(random)).also { open-- }
                else -> counters.reconcile(random.nextLong(2_000))
            }
            val counts = counters.snapshot()
            assertEquals(counts.produced, counts.sent + counts.dropped.values.sum() + open)
        }
    }

    private fun assertBooks(produced: Long, sent: Long, vararg dropped: Pair<String, Long>) {
        val counts = counters.snapshot()
        assertEquals(produced, counts.produced)
        assertEquals(sent, counts.sent)
        assertEquals(mapOf(*dropped), counts.dropped)
    }
}
