package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals

class ChannelAccountTest {
    private val account = ChannelAccount()

    @Test
    fun sequenceNumbersCountFromZeroAndLeaveGapsForWhatASourceLost() {
        assertEquals(listOf(0, 1), List(2) { account.produce() })
        account.lose(3, DropReason.NO_BUFFER)
        assertEquals(5, account.produce())
        assertBooks(produced = 6, sent = 0, "no_buffer" to 3)
    }

    @Test
    fun sequenceNumbersAreModuloTwoToThe32() {
        account.lose(Int.MAX_VALUE, DropReason.SOURCE_LATE)
        assertEquals(Int.MAX_VALUE, account.produce())
        account.lose(Int.MAX_VALUE, DropReason.SOURCE_LATE)
        assertEquals(-1, account.produce())
        assertEquals(0, account.produce())
    }

    @Test
    fun onlyReasonsThatOccurredAreNamed() {
        repeat(4) { account.produce() }
        account.sent()
        account.drop(DropReason.QUEUE_FULL)
        account.drop(DropReason.ENCODER_BUSY)
        account.drop(DropReason.CLOCK_STEP)
        assertBooks(produced = 4, sent = 1, "queue_full" to 1, "encoder_busy" to 1, "clock_step" to 1)
    }

    @Test
    fun whatWasSentButDidNotArriveWentDownWithTheLink() {
        repeat(10) { account.produce() }
        repeat(8) { account.sent() }
        repeat(2) { account.drop(DropReason.QUEUE_FULL) }
        account.settle(received = 5)
        assertBooks(produced = 10, sent = 5, "queue_full" to 2, "link_down" to 3)
        account.settle(received = 5)
        assertBooks(produced = 10, sent = 5, "queue_full" to 2, "link_down" to 3)
    }

    @Test
    fun whatWasUnderWayWhenTheLinkBrokeMayHaveArrived() {
        repeat(5) { account.produce() }
        repeat(3) { account.sent() }
        repeat(2) { account.drop(DropReason.LINK_DOWN) }
        account.settle(received = 4)
        assertBooks(produced = 5, sent = 4, "link_down" to 1)
    }

    @Test
    fun aReceiverThatClaimsTooMuchCannotMakeDropsNegative() {
        repeat(5) { account.produce() }
        repeat(3) { account.sent() }
        repeat(2) { account.drop(DropReason.LINK_DOWN) }
        account.settle(received = Long.MAX_VALUE)
        assertBooks(produced = 5, sent = 5)
    }

    @Test
    fun booksBalanceWhateverHappens() {
        val random = Random(5)
        var open = 0
        repeat(2_000) {
            when (random.nextInt(5)) {
                0, 1 -> account.produce().also { open++ }
                2 -> if (open > 0) account.sent().also { open-- }
                3 -> if (open > 0) account.drop(DropReason.entries.random(random)).also { open-- }
                else -> account.settle(random.nextLong(2_000))
            }
            val counts = account.counts()
            assertEquals(counts.produced, counts.sent + counts.dropped.values.sum() + open)
        }
    }

    private fun assertBooks(produced: Long, sent: Long, vararg dropped: Pair<String, Long>) {
        val counts = account.counts()
        assertEquals(produced, counts.produced)
        assertEquals(sent, counts.sent)
        assertEquals(mapOf(*dropped), counts.dropped)
    }
}
