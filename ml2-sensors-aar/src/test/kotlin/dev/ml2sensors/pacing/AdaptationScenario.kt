package dev.ml2sensors.pacing

import dev.ml2sensors.table.StreamTable
import kotlin.math.max
import kotlin.math.min
import kotlin.math.pow
import kotlin.random.Random

/**
 * Streams that send over a link in virtual time, with a queue of four images for each stream. Images have other sizes
 * than the stream table says, and the pacing knows the link's rate roughly.
 *
 * @param spread by which part the sizes of images, and how they fall with the quality, are random.
 * @param onChange receives the streams after each change.
 */
internal class AdaptationScenario(
    val streams: List<AdaptedStream>,
    seed: Int,
    spread: Double = 0.3,
    private val onChange: (List<AdaptedStream>) -> Unit = {},
) {
    class Change(val atNanos: Long, val level: Int)

    var nowNanos = 1_000_000_000_000L
        private set
    val adaptation = LinkAdaptation(streams, StreamTable.adaptation, nowNanos)
    val changes = ArrayList<Change>()

    private val random = Random(seed)

    /** The factor of a JPEG's size for each 20 less of quality. */
    private val falls = 0.72 * any(spread)
    private val bytesOfImage = streams.associateWith { configuredBytes(it) * any(spread) }
    private var sentBytes = 0.0
    private var queuedBytes = 0.0
    private var droppedImages = 0L
    private var waitingSince: Long? = null
    private var pacedMbit = 10.0
    private var isLinkKnown = false

    val neededMbit: Double get() = streams.sumOf { bytes(it) * it.present.rateHz } * 8e-6

    /** Goes on over a link with [mbit] for images; 0 stands still. */
    fun run(mbit: Double, seconds: Int) = repeat(seconds * TICKS) { tick(mbit) }

    private fun tick(mbit: Double) {
        nowNanos += SECOND / TICKS
        for (stream in streams) {
            val images = stream.present.rateHz / TICKS.toDouble()
            if (random.nextDouble() < images) stream.published((bytes(stream) * any(0.05)).toInt(), stream.present)
        }
        if (mbit > 0) pace(mbit)
        val offered = neededMbit / 8e-6 / TICKS * any(0.05)
        val room = minOf(mbit, pacedMbit) / 8e-6 / TICKS
        val most = streams.sumOf { QUEUE_IMAGES * bytes(it) }
        val waits = queuedBytes + offered
        val delivered = minOf(waits, room)
        sentBytes += delivered
        if (waits - delivered > most) droppedImages++
        queuedBytes = minOf(waits - delivered, most)
        waitingSince = if (queuedBytes > 0) waitingSince ?: nowNanos else null
        val isUnsettled = mbit == 0.0 || (waitingSince != null && !isLinkKnown)
        val link = LinkState(waitingSince, isUnsettled, droppedImages, sentBytes.toLong(), pacedMbit / 8e-6)
        if (adaptation.adaptTo(link, nowNanos)) {
            changes += Change(nowNanos, adaptation.level)
            onChange(streams)
        }
    }

    /** The pacing finds the rate of a link while images wait, or in bursts of images with pauses. */
    private fun pace(mbit: Double) {
        val growth = when {
            waitingSince == null -> 2.0.pow(BURST_GROWTH * min(1.0, neededMbit / pacedMbit))
            isLinkKnown -> GROWTH
            else -> START_GROWTH
        }
        // Small images fit into the queue of a fast link at any rate
        val queueBytes = mbit / 8e-6 * QUEUE_SECONDS
        if (waitingSince == null && streams.sumOf { bytes(it) } < queueBytes) {
            pacedMbit = min(pacedMbit * growth, 1000.0)
        } else if (pacedMbit * growth < 0.85 * mbit) {
            pacedMbit *= growth
        } else {
            isLinkKnown = true
            pacedMbit = max(0.5, mbit * (0.85 + 0.25 * random.nextDouble()))
        }
    }

    private fun bytes(stream: AdaptedStream): Double {
        val lowered = (stream.configured.quality ?: 0) - (stream.present.quality ?: 0)
        return bytesOfImage.getValue(stream) * falls.pow(lowered / 20.0)
    }

    private fun any(spread: Double) = 1 + spread * (2 * random.nextDouble() - 1)

    /** As measured on the simulated headset. */
    private fun configuredBytes(stream: AdaptedStream): Double = when {
        "world" in stream.id -> if (stream.configured.quality == null) 1_032_000.0 else 139_000.0
        "eye" in stream.id -> if (stream.configured.quality == null) 160_000.0 else 14_600.0
        stream.id == "depth" -> 95_000.0
        else -> 250_000.0
    }

    private companion object {
        const val SECOND = 1_000_000_000L
        const val TICKS = 10

        /** By which factor the pacing's rate grows in a tick, over its plateau and beyond, and before it knows a link. */
        const val GROWTH = 1.05
        const val BURST_GROWTH = 0.05

        /** The pacing lets a queue become so long. */
        const val QUEUE_SECONDS = 0.008
        const val START_GROWTH = 1.4
        const val QUEUE_IMAGES = 4
    }
}
