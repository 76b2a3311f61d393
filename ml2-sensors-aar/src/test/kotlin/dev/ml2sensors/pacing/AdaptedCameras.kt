package dev.ml2sensors.pacing

import dev.ml2sensors.table.StreamTable
import kotlin.random.Random

/**
 * All cameras of the demo, compressed, with a queue of four images each, which send over a [VirtualLink] and adapt to it.
 * Images have the sizes that the simulated headset's have, randomly more or less.
 */
internal class AdaptedCameras(seed: Int) {
    /** One camera; with quality 40, its images have the part [atQuality40] of their bytes. */
    private class Camera(
        id: String,
        quality: Int?,
        private val bytes: Double,
        private val atQuality40: Double,
        val phaseMillis: Int,
    ) {
        val stream = AdaptedStream(id, ImageSetting(RATE_HZ, quality))
        val queue = ArrayDeque<Double>()
        var waitingSinceNanos: Long? = null

        /** The size of an image at present. */
        val presentBytes: Double
            get() = when (stream.present.quality) {
                40 -> bytes * atQuality40
                60 -> bytes * (0.5 + atQuality40 / 2)
                else -> bytes
            }
    }

    private val random = Random(seed)
    private val cameras =
        listOf("world_center", "world_left", "world_right").map { Camera(it, 80, any(137e3), 0.51, phaseMillis = 3) } +
            listOf("nasal_left", "nasal_right", "temple_left", "temple_right")
                .map { Camera("eye_$it", 80, 14.6e3, 0.44, phaseMillis = 11) } +
            listOf("color" to 245e3, "depth" to 96e3)
                .map { (id, bytes) -> Camera(id, null, any(bytes), 1.0, random.nextInt(PERIOD_MILLIS)) }
    private val streams = cameras.map { it.stream }
    private val adaptation = LinkAdaptation(streams, StreamTable.adaptation, nowNanos = 0)
    private val stepNanos = ArrayList<Long>()
    private var droppedImages = 0L
    private var turn = 0

    /** The bytes of images that wait to be sent. */
    val waitingBytes: Double get() = cameras.sumOf { it.queue.sum() }

    /** The present rate of the slowest camera. */
    val leastHz: Int get() = streams.minOf { it.present.rateHz }

    fun steps(afterSecond: Double): Int = stepNanos.count { it >= afterSecond * 1e9 }

    /** Offers the images of a millisecond. */
    fun capture(millis: Int) {
        val nowNanos = millis * 1_000_000L
        for (camera in cameras.filter { millis % PERIOD_MILLIS == it.phaseMillis }) {
            val stream = camera.stream
            if (!stream.admits(nowNanos)) continue
            val bytes = camera.presentBytes * (0.96 + 0.08 * random.nextDouble())
            stream.published(bytes.toInt(), stream.present)
            // The first one is being written
            if (camera.queue.size > QUEUE_IMAGES) {
                camera.queue.removeAt(1)
                droppedImages++
            }
            camera.queue += bytes
            if (camera.waitingSinceNanos == null) camera.waitingSinceNanos = nowNanos
        }
    }

    /** The link takes [bytes], of the cameras in turns. */
    fun send(bytes: Double, nowNanos: Long) {
        var left = bytes
        while (left > 0) {
            val camera =
                cameras.indices.map { cameras[(turn + it) % cameras.size] }.firstOrNull { it.queue.isNotEmpty() }
                    ?: return
            turn = cameras.indexOf(camera) + 1
            val taken = minOf(left, camera.queue.first(), ImagePacing.SLICE_BYTES.toDouble())
            left -= taken
            camera.queue[0] -= taken
            if (camera.queue.first() > 0) continue
            camera.queue.removeFirst()
            if (camera.queue.isEmpty()) camera.waitingSinceNanos = null
        }
    }

    /** Adapts to what [rate] knows of the link, as the session does ten times a second. */
    fun adapt(rate: ImageRate, sentBytes: Long, nowNanos: Long) {
        val waitingSince = cameras.mapNotNull { it.waitingSinceNanos }.minOrNull()
        val isSearching = rate.isSearching(nowNanos)
        val link = LinkState(waitingSince, isSearching, droppedImages, sentBytes, rate.bytesPerSecond(nowNanos))
        if (adaptation.adaptTo(link, nowNanos)) stepNanos += nowNanos
        rate.isMoreWanted = streams.any { it.present != it.configured }
    }

    private fun any(bytes: Double) = bytes * (0.85 + 0.3 * random.nextDouble())

    private companion object {
        const val RATE_HZ = 30
        const val PERIOD_MILLIS = 33
        const val QUEUE_IMAGES = 4
    }
}
