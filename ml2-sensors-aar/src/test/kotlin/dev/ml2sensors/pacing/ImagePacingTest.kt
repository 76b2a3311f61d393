package dev.ml2sensors.pacing

import org.junit.jupiter.api.Test
import kotlin.concurrent.thread
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

/** In virtual time, in which a thread that waits lets time pass. */
class ImagePacingTest {
    private var nanos = -5_000_000_000L
    private var isBlocked = false
    private val pacing = ImagePacing({ nanos }, { nanos += it }) { isBlocked }

    @Test
    fun imagesGoAtTenMegabitsPerSecondAndDoubleWhileTheyWait() {
        val tenth = secondsFor(128_000)
        assertTrue(tenth in 0.07..0.11, "$tenth s for 128 kB")
        val next = secondsFor(6_400_000)
        assertTrue(next in 0.7..0.9, "$next s for 6.4 MB, at up to 200 Mbit/s")
    }

    @Test
    fun whatIsNotLimitedDoesNotGrow() {
        repeat(100) {
            assertEquals(0.0, secondsFor(ImagePacing.SLICE_BYTES))
            nanos += 50_000_000
        }
        val tenth = secondsFor(128_000)
        assertTrue(tenth in 0.07..0.11, "$tenth s for 128 kB")
    }

    @Test
    fun aQueueOfTheLinkLowersTheRateToWhatItDelivered() {
        repeat(20) { roundTrip(1_000_000) }
        secondsFor(2_000_000)
        val before = secondsFor(200_000)
        repeat(2) { roundTrip(30_000_000) }
        val during = secondsFor(200_000)
        assertTrue(during > 2 * before, "$before s before, $during s while the queue is drained")
    }

    @Test
    fun imagesLetSmallMessagesPassForAQuarterOfASecondAtMost() {
        isBlocked = true
        secondsFor(ImagePacing.SLICE_BYTES)
        val waited = secondsFor(ImagePacing.SLICE_BYTES)
        assertTrue(waited in 0.2..0.27, "$waited s")
        isBlocked = false
        assertTrue(secondsFor(ImagePacing.SLICE_BYTES) < 0.02)
    }

    @Test
    fun imagesWaitWhileTheLinkStandsStill() {
        duringRoundTrip {
            nanos += 201_000_000
            secondsFor(ImagePacing.SLICE_BYTES)
            assertTrue(secondsFor(ImagePacing.SLICE_BYTES) > 0.2)
        }
        secondsFor(ImagePacing.SLICE_BYTES)
        assertTrue(secondsFor(ImagePacing.SLICE_BYTES) < 0.02)
    }

    @Test
    fun imagesWaitForWhatTheReceiverHasNotAcknowledged() {
        var underWayBytes = 1_000_000
        val queue = { underWayBytes }
        pacing.add(queue)
        secondsFor(ImagePacing.SLICE_BYTES)
        assertTrue(secondsFor(ImagePacing.SLICE_BYTES) > 0.2)
        underWayBytes = ImagePacing.SLICE_BYTES
        assertTrue(secondsFor(ImagePacing.SLICE_BYTES) < 0.02)
        underWayBytes = 1_000_000
        pacing.remove(queue)
        assertTrue(secondsFor(ImagePacing.SLICE_BYTES) < 0.02)
    }

    @Test
    fun aReceiverThatAnswersLateButHasAllImagesChangesNothing() {
        val nothing = { 0 }
        pacing.add(nothing)
        repeat(20) { roundTrip(1_000_000) }
        secondsFor(2_000_000)
        val before = secondsFor(200_000)
        repeat(2) { roundTrip(30_000_000) }
        assertTrue(secondsFor(200_000) <= before)
    }

    @Test
    fun onlyAQueueOnTheWayToTheReceiverSlowsImages() = pacing.image {
        repeat(20) { roundTrip(1_000_000, thereNanos = 500_000) }
        secondsFor(2_000_000)
        val before = secondsFor(200_000)
        repeat(2) { roundTrip(30_000_000, thereNanos = 600_000) }
        assertTrue(secondsFor(200_000) < 1.1 * before, "the answers wait")
        duringRoundTrip(thereNanos = 600_000) {
            nanos += 80_000_000
            secondsFor(ImagePacing.SLICE_BYTES)
            assertTrue(secondsFor(200_000) > 2 * before, "congested until it is known where the queue was")
        }
        assertTrue(secondsFor(200_000) < 1.5 * before, "it was on the way back")
        nanos += 300_000_000
        secondsFor(ImagePacing.SLICE_BYTES)
        repeat(2) { roundTrip(30_000_000, thereNanos = 29_500_000) }
        assertTrue(secondsFor(200_000) > 2 * before, "images wait")
    }

    @Test
    fun aLinkThatStoodStillHasTheRateThatItHad() = pacing.image {
        repeat(20) { roundTrip(1_000_000) }
        secondsFor(2_000_000)
        val before = secondsFor(200_000)
        duringRoundTrip {
            nanos += 30_000_000
            secondsFor(ImagePacing.SLICE_BYTES)
            assertTrue(secondsFor(200_000) > 2 * before, "congested until the link is known to stand still")
            nanos += 300_000_000
        }
        val after = secondsFor(200_000)
        assertTrue(after < 1.5 * before, "$before s before, $after s after")
    }

    @Test
    fun atTheEndNothingWaits() {
        isBlocked = true
        pacing.end()
        assertEquals(0.0, secondsFor(10_000_000))
    }

    @Test
    fun aThreadThatWaitsCanBeInterrupted() {
        val waiting = ImagePacing { false }
        val interrupted = thread(start = false) {
            assertFailsWith<InterruptedException> { while (true) waiting.await(ImagePacing.SLICE_BYTES) }
        }
        var failure: Throwable? = null
        interrupted.setUncaughtExceptionHandler { _, error -> failure = error }
        interrupted.start()
        interrupted.interrupt()
        interrupted.join()
        assertEquals(null, failure)
    }

    private fun roundTrip(nanos: Long, thereNanos: Long? = null) =
        duringRoundTrip(thereNanos) { this.nanos += nanos }

    private fun duringRoundTrip(thereNanos: Long? = null, block: () -> Unit) = pacing.measured(block) { thereNanos }

    private fun secondsFor(bytes: Int): Double {
        val began = nanos
        repeat(bytes / ImagePacing.SLICE_BYTES) {
            pacing.await(ImagePacing.SLICE_BYTES)
            pacing.written(ImagePacing.SLICE_BYTES)
        }
        return (nanos - began) * 1e-9
    }
}
