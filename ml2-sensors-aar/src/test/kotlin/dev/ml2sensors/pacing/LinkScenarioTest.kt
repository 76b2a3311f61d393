package dev.ml2sensors.pacing

import dev.ml2sensors.report
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import org.junit.jupiter.api.AfterAll
import org.junit.jupiter.api.Tag
import org.junit.jupiter.api.Test
import kotlin.math.max
import kotlin.math.min
import kotlin.test.assertTrue

/** Measures the delay of small messages, and the share of a link that images use, on many links in virtual time. */
@Tag("long-computation")
class LinkScenarioTest {
    @Test
    fun smallMessagesAreOnTimeOnEveryLinkThatImagesFill() {
        val results = listOf(10.0, 12.0, 20.0, 30.0, 50.0, 100.0, 300.0, 1000.0).flatMap { mbit ->
            listOf(1, 5, 20, 50, 100).flatMap { roundTripMillis ->
                listOf(20, 50, 200, 500).flatMap { queueMillis ->
                    playBoth("steady") { VirtualLink(roundTripMillis, queueMillis, downlink = it) { mbit } }
                }
            }
        }
        played += results
        for (it in results) {
            // The tolerated delay and what may be under way besides, and a part of a long path. Small messages fill
            // half of a slow link, or nine tenths of the slowest, and one slice of an image takes it for 10 ms.
            val limit = when {
                it.linkMbit < 12 -> 10 + it.roundTripMillis / (if (it.hasDownlink) 3.0 else 4.0)
                it.linkMbit < 30 -> 10 + it.roundTripMillis / 5.0
                else -> 8 + it.roundTripMillis / 8.0
            }
            assertTrue(it.delayP99Millis < limit, "$it: delay")
            assertTrue(it.use > 0.8, "$it: use")
            assertTrue(it.settledSeconds < 5, "$it: settled")
        }
    }

    @Test
    fun adaptedCamerasUseMostOfALinkInFewSteps() {
        val links = listOf(45.0, 70.0, 100.0, 140.0, 180.0).flatMap { mbit -> listOf(0, 20, 60).map { mbit to it } }
        for ((mbit, roundTripMillis) in links) {
            val steps = (1..10).map { seed ->
                val cameras = AdaptedCameras(seed)
                val result = VirtualLink(roundTripMillis, queueMillis = 50, cameras = cameras) { mbit }.play("auto")
                played += result
                val unused = (1 - result.use) * (mbit - VirtualLink.SENSORS_MBIT)
                assertTrue(unused < 0.24 * mbit, "seed $seed, $result: use")
                assertTrue(cameras.leastHz >= 5, "seed $seed, $result: ${cameras.leastHz} Hz")
                assertTrue(result.delayP99Millis < if (roundTripMillis < 60) 15 else 25, "seed $seed, $result: delay")
                cameras.steps(afterSecond = VirtualLink.SETTLED_SECOND)
            }
            // A long path is known later
            val most = 4 + roundTripMillis / 20.0
            val isFew = steps.average() <= 4 && steps.all { it <= most }
            assertTrue(isFew, "$mbit Mbit/s, $roundTripMillis ms: $steps steps")
        }
    }

    @Test
    fun imagesThatTheLinkCarriesAreNotHeldBack() {
        val results = listOf(2, 10, 20).flatMap { roundTripMillis ->
            listOf(300.0, 500.0, 1000.0).flatMap { mbit ->
                playBoth("204 Mbit/s of images") {
                    VirtualLink(roundTripMillis, queueMillis = 50, imagesMbit = 204.0, downlink = it) { mbit }
                }
            }
        }
        played += results
        for (it in results) {
            assertTrue(it.delayP99Millis < 20, "$it: delay")
            assertTrue(it.imagesP99Millis < 100, "$it: a queue of four images is full after 133 ms")
        }
    }

    @Test
    fun aDelayFromElsewhereCostsLittle() {
        val other = { second: Double -> if (second % 8 < 0.06) 12.0 else 0.0 }
        val result = VirtualLink(10, queueMillis = 50, imagesMbit = 204.0, routeMillis = other) { 300.0 }
            .play("delay from elsewhere")
        assertTrue(result.imagesP99Millis < 400, "$result")
    }

    @Test
    fun aReceiverWhoseProgramIsBusyCostsNothing() {
        val busyAtStart = { second: Double -> if (second < 1.5) 30.0 else 0.0 }
        val busyOften = { second: Double -> if (second % 2 < 0.3) 25.0 else 0.0 }
        for (answerMillis in listOf(busyAtStart, busyOften)) {
            val some = VirtualLink(2, 50, imagesMbit = 100.0, answerMillis = answerMillis) { 300.0 }.play("some images")
            assertTrue(some.imagesP99Millis < 33, "$some: an image is sent before the next one comes")
            val all = VirtualLink(2, 50, answerMillis = answerMillis) { 300.0 }.play("as many as the link carries")
            assertTrue(all.use > 0.9, "$all")
        }
    }

    @Test
    fun imagesWithPausesFindABetterLinkSoonerIfMoreIsWanted() {
        val (enough, wanted) = listOf(false, true).map { isMoreWanted ->
            val mbit = { second: Double -> if (second < 55) 20.0 else 100.0 }
            val link = VirtualLink(2, queueMillis = 50, imagesMbit = 10.0, isMoreWanted, mbit = mbit)
            link.play("better link")
            link.foundMbit
        }
        assertTrue(wanted > 100 && wanted > 2 * enough, "$wanted Mbit/s, or $enough where nothing more is wanted")
    }

    @Test
    fun aChangedLinkIsFollowedWithinFiveSeconds() {
        val longer = { second: Double -> if (second > 20) 40.0 else 0.0 }
        val results = listOf(
            playBoth("100, 20, 100") {
                VirtualLink(2, 50, downlink = it) { at -> if (at.toInt() / 10 % 2 == 0) 100.0 else 20.0 }
            },
            playBoth("stalls") { VirtualLink(2, 50, downlink = it) { at -> if (at % 10 in 5.0..5.5) 0.0 else 100.0 } },
            playBoth("longer route") { VirtualLink(2, 50, routeMillis = longer, downlink = it) { 100.0 } },
            playBoth("another sender") {
                VirtualLink(2, 50, downlink = it) { at -> if (at in 10.0..20.0) 50.0 else 100.0 }
            },
        ).flatten()
        played += results
        for (it in results) {
            assertTrue(it.delayP99Millis < 60, "$it: delay")
            assertTrue(it.use > if (it.hasDownlink) 0.8 else 0.85, "$it: use")
            assertTrue(it.settledSeconds < 5, "$it: settled")
        }
    }

    @Test
    fun aQueueOnTheWayBackCostsLittle() {
        // Something else than the receiver fills it, which does not pace
        val filled = { second: Double -> if (second % 4 < 2) 50.0 else 0.0 }
        val results = listOf(30.0, 100.0, 300.0).map { mbit ->
            VirtualLink(5, queueMillis = 100, downlink = filled) { mbit }.play("another receives")
        }
        played += results
        for (it in results) assertTrue(it.use > 0.85 && it.delayP99Millis < 20, "$it")
    }

    /** Plays a link alone, and beside messages to the headset, which the receiver paces to a queue of 3 ms. */
    private fun playBoth(name: String, link: (downlink: ((Double) -> Double)?) -> VirtualLink) = listOf(
        link(null).play(name),
        link { second -> if (second % 0.5 < 0.3) 3.0 else 0.0 }.play(name),
    )

    private companion object {
        val played = ArrayList<ScenarioResult>()

        @AfterAll
        @JvmStatic
        fun reportAll(): Unit = report("pacing.json", played)
    }
}

/** A row of build/reports/pacing.json. The delay is that of the link's queue; use is that of what images could have. */
@Serializable
internal data class ScenarioResult(
    val scenario: String,
    @SerialName("link_mbit") val linkMbit: Double,
    @SerialName("rtt_ms") val roundTripMillis: Int,
    @SerialName("queue_ms") val queueMillis: Int,
    @SerialName("downlink") val hasDownlink: Boolean,
    @SerialName("delay_p99_ms") val delayP99Millis: Double,
    @SerialName("images_p99_ms") val imagesP99Millis: Double,
    val use: Double,
    @SerialName("settled_s") val settledSeconds: Double,
)

/**
 * A link with one queue, as a fluid in steps of a millisecond. What the queue cannot take is lost,
 * and its sender writes nothing for a round trip.
 *
 * @param imagesMbit what the images need, which come together 30 times a second; if infinite, images always wait.
 * @param isMoreWanted as in [ImageRate].
 * @param routeMillis returns what the route adds to the round trip at a second.
 * @param answerMillis returns how long the receiver's program takes to answer at a second.
 * @param downlink returns how long the queue on the way back is at a second, in ms; null if there is none, and the
 * receiver's clock is unknown.
 * @param cameras send images instead, and adapt to the link; then use is that from [SETTLED_SECOND] on.
 * @param mbit returns the link's rate at a second.
 */
internal class VirtualLink(
    private val roundTripMillis: Int,
    private val queueMillis: Int,
    private val imagesMbit: Double = Double.POSITIVE_INFINITY,
    isMoreWanted: Boolean = false,
    private val routeMillis: (second: Double) -> Double = { 0.0 },
    private val answerMillis: (second: Double) -> Double = { 0.0 },
    private val downlink: ((second: Double) -> Double)? = null,
    private val cameras: AdaptedCameras? = null,
    private val mbit: (second: Double) -> Double,
) {
    private val rate = ImageRate(0).also { it.isMoreWanted = isMoreWanted }
    private var queueBytes = 0.0

    /** The bytes of images that were written, and that had left the queue by each of the milliseconds. */
    private var writtenBytes = 0.0
    private val passedBytes = DoubleArray(SECONDS * 1000)

    /** The bytes of images that were not written yet. */
    private var waitingBytes = 0.0
    private var acknowledgedBytes = 0.0
    private var roundTrip: RoundTrip? = null
    private var askMillis = ASK_MILLIS
    private var endMillis = 0.0
    private var thereNanos: Long? = null

    /** The rate at the end. */
    val foundMbit: Double get() = rate.bytesPerSecond(SECONDS * 1000 * NANOS_PER_MILLI) / BYTES_PER_MBIT_MILLI / 1000

    fun play(name: String): ScenarioResult {
        val delays = ArrayList<Double>()
        val imageDelays = ArrayList<Double>()
        var used = 0.0
        var offered = 0.0
        var unsettled = 0.0
        for (millis in 0 until SECONDS * 1000) {
            val second = millis / 1000.0
            val bytesPerMilli = mbit(second) * BYTES_PER_MBIT_MILLI
            val sensors = min(SENSORS_MBIT * BYTES_PER_MBIT_MILLI, bytesPerMilli)
            val images = step(millis, bytesPerMilli, sensors)
            val delay = if (bytesPerMilli == 0.0) 0.0 else queueBytes / bytesPerMilli
            val there = delay + roundTripMillis / 2.0 + routeMillis(second)
            askAndAnswer(millis, there, there + roundTripMillis / 2.0 + answerMillis(second) + returnMillis(second))
            if (bytesPerMilli == 0.0) continue
            if (second >= SETTLING_SECONDS) {
                delays += delay
                imageDelays += waitingBytes / (imagesMbit * BYTES_PER_MBIT_MILLI)
            }
            if (cameras == null || second >= SETTLED_SECOND) {
                used += images
                offered += bytesPerMilli - sensors
            }
            val isSettled = delay < SETTLED_MILLIS + roundTripMillis / 2.0
            if (!isSettled && second < SETTLING_SECONDS) unsettled = second
        }
        return ScenarioResult(
            name,
            mbit(0.0),
            roundTripMillis,
            queueMillis,
            downlink != null,
            delays.p99(),
            if (imagesMbit.isFinite()) imageDelays.p99() else 0.0,
            used / offered,
            unsettled,
        )
    }

    private fun returnMillis(second: Double) = downlink?.invoke(second) ?: 0.0

    private fun List<Double>.p99() = sorted()[(size * 0.99).toInt()]

    /** Returns how many bytes of images are written in this millisecond. */
    private fun step(millis: Int, bytesPerMilli: Double, sensors: Double): Double {
        if (millis < FIRST_IMAGE_MILLIS) return 0.0
        val now = millis * NANOS_PER_MILLI
        offer(millis)
        if (waitingBytes > 0) rate.images.resume(now)
        val limit = queueMillis * max(bytesPerMilli, 1.0)
        queueBytes = min(queueBytes, limit)
        val room = max(0.0, limit + bytesPerMilli - queueBytes - sensors)
        val second = millis / 1000.0
        val path = roundTripMillis + (routeMillis(second) + returnMillis(second)).toInt()
        acknowledgedBytes = max(acknowledgedBytes, passedBytes[max(0, millis - 1 - path)])
        val underWay = max(0.0, rate.mostUnderWayBytes(now) - (writtenBytes - acknowledgedBytes))
        val images = min(waitingBytes, minOf(rate.bytesPerSecond(now) / 1000, room, underWay))
        writtenBytes += images
        rate.acknowledged(acknowledgedBytes.toLong(), writtenBytes.toLong(), now)
        roundTrip?.acknowledged(acknowledgedBytes.toLong(), now)
        if (images >= 1) rate.images.written(now)
        waitingBytes -= images
        cameras?.send(images, now)
        if (millis % ADAPT_MILLIS == 0) cameras?.adapt(rate, writtenBytes.toLong(), now)
        if (waitingBytes > 0) rate.waited(now) else rate.images.pause(now)
        queueBytes = max(0.0, queueBytes + sensors + images - bytesPerMilli)
        passedBytes[millis] = writtenBytes - queueBytes
        return images
    }

    private fun offer(millis: Int) {
        if (cameras != null) {
            cameras.capture(millis)
            waitingBytes = cameras.waitingBytes
            return
        }
        if (!imagesMbit.isFinite()) waitingBytes = Double.MAX_VALUE
        val isBurst = millis % FRAME_MILLIS == 0
        if (isBurst) waitingBytes += imagesMbit.coerceAtMost(1e6) * BYTES_PER_MBIT_MILLI * FRAME_MILLIS
    }

    private fun askAndAnswer(
        millis: Int,
        thereMillis: Double,
        durationMillis: Double,
    ) {
        val now = millis * NANOS_PER_MILLI
        val roundTrip = roundTrip
        if (roundTrip == null) {
            if (millis < askMillis) return
            this.roundTrip = RoundTrip(now, writtenBytes.toLong(), acknowledgedBytes.toLong())
            askMillis = millis + ASK_MILLIS
            endMillis = millis + durationMillis
            thereNanos = downlink?.let { (thereMillis * NANOS_PER_MILLI).toLong() + CLOCK_ERROR_NANOS }
        } else if (millis < endMillis) {
            if (roundTrip.isBehindImages) rate.unanswered(roundTrip.startNanos, now)
        } else {
            val end = (endMillis * NANOS_PER_MILLI).toLong()
            rate.roundTrip(end - roundTrip.startNanos, roundTrip.onPathNanos(end), thereNanos, now)
            this.roundTrip = null
        }
    }

    companion object {
        /** When cameras have adapted to a link, and the share of it that small messages have. */
        const val SETTLED_SECOND = 10.0
        const val SENSORS_MBIT = 9.0
        private const val ADAPT_MILLIS = 100
        private const val SECONDS = 60
        private const val SETTLING_SECONDS = 3.0
        private const val SETTLED_MILLIS = 15
        private const val FRAME_MILLIS = 33
        private const val ASK_MILLIS = 20

        /** The time lane comes first. */
        private const val FIRST_IMAGE_MILLIS = 500
        private const val BYTES_PER_MBIT_MILLI = 125.0
        private const val NANOS_PER_MILLI = 1_000_000L

        /** The receiver's clock is estimated to be earlier than it is. */
        private const val CLOCK_ERROR_NANOS = -1_500_000L
    }
}
