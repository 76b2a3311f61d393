package dev.ml2sensors.stream

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.CaptureMetadata
import dev.ml2sensors.source.CountedBuffers
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.ensureActive
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.update
import java.util.concurrent.ConcurrentHashMap

/**
 * A headset whose sensors deliver what the test says, when it says so. It is strict: streams run only with values that
 * were agreed on, and image memory is borrowed from [pool] for no longer than [Headset] allows.
 */
internal class FakeHeadset(override val timeline: Headset.Timeline = Headset.Timeline.LIVE) : Headset {
    private class Delivery(val sample: Sample) {
        val isDone = CompletableDeferred<Boolean>()

        fun finish(arrived: Boolean) {
            if (isDone.complete(arrived)) (sample as? ImageSample)?.release()
        }
    }

    private class Feed(val stream: StreamSpec) {
        val priority = Thread.currentThread().priority
        val deliveries = Channel<Delivery>(Channel.RENDEZVOUS, onUndeliveredElement = { it.finish(false) })
    }

    private val feeds = MutableStateFlow(emptyList<Feed>())
    private val agreed = ConcurrentHashMap.newKeySet<Pair<StreamSpec, StreamValues>>()

    /** The answers of streams that do not just apply what is asked for. */
    val answers = ConcurrentHashMap<StreamSpec, Answer>()

    /** Returns the permissions; may throw. */
    @Volatile
    var readPermissions: () -> Map<String, Boolean> = ::emptyMap
    override val permissions get() = readPermissions()

    /** Streams whose negotiation throws. */
    val broken = ConcurrentHashMap<StreamSpec, RuntimeException>()

    /** The reasons why streams deliver nothing. */
    @Volatile
    override var holds = emptyMap<String, String>()

    @Volatile
    override var suspendedNanos = 7_000_000_000L
    val pool = CountedBuffers(bufferBytes = 1 shl 16)
    override val identity = Headset.Identity("fake-1", "Fake")
    override val clock = DeviceClock { System.nanoTime() + 5_000_000_000_000 }

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        broken[stream]?.let { throw it }
        val answer = answers[stream] ?: Answer.Applied(requested)
        when (answer) {
            is Answer.Applied -> agreed += stream to answer.values
            is Answer.Adjusted -> agreed += stream to answer.values
            is Answer.Refused -> Unit
        }
        return answer
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        check(stream to values in agreed) { "$stream was not agreed to run with $values" }
        return flow {
            val feed = Feed(stream)
            feeds.update { it + feed }
            try {
                for (delivery in feed.deliveries) {
                    try {
                        emit(delivery.sample)
                    } finally {
                        delivery.finish(true)
                    }
                }
            } finally {
                feeds.update { it - feed }
                feed.deliveries.cancel()
            }
        }
    }

    /** Waits until [stream] runs, [times] over; delivers [sample], and returns when all that run it are done with it. */
    suspend fun deliver(stream: StreamSpec, sample: Sample, times: Int = 1): Boolean {
        val running = try {
            awaitFeeds(stream, times)
        } catch (cancelled: CancellationException) {
            (sample as? ImageSample)?.release()
            throw cancelled
        }
        return running.map { deliver(it, sample) }.all { it }
    }

    private suspend fun deliver(feed: Feed, sample: Sample): Boolean {
        val delivery = Delivery(sample)
        try {
            feed.deliveries.send(delivery)
        } catch (_: CancellationException) {
            currentCoroutineContext().ensureActive() // else it is the stream that was stopped
        }
        return delivery.isDone.await()
    }

    /** Waits until [stream] runs; returns the priority of its thread. */
    suspend fun awaitPriority(stream: StreamSpec): Int = awaitFeeds(stream, times = 1).single().priority

    private suspend fun awaitFeeds(stream: StreamSpec, times: Int): List<Feed> =
        feeds.first { all -> all.count { it.stream == stream } >= times }.filter { it.stream == stream }

    /** The sensor of [stream] breaks, or is at its end when [cause] is null. */
    suspend fun end(
        stream: StreamSpec,
        cause: Exception?,
    ) = awaitFeeds(stream, 1).forEach { it.deliveries.close(cause) }

    suspend fun awaitRunning(stream: StreamSpec) {
        awaitFeeds(stream, 1)
    }

    fun isRunning(stream: StreamSpec): Boolean = feeds.value.any { it.stream == stream }

    suspend fun awaitStopped(stream: StreamSpec) {
        feeds.first { all -> all.none { it.stream == stream } }
    }

    /** An image in borrowed memory, each plane [rowBytes] x [height] bytes of its own pattern. */
    fun image(
        captureNanos: Long,
        number: Long = 0,
        rowBytes: Int = 64,
        height: Int = 32,
        roles: List<String> = listOf("image"),
        pose: Transform? = null,
        intrinsics: Intrinsics? = null,
        metadata: CaptureMetadata = CaptureMetadata(),
    ): ImageSample {
        val planes = roles.map { role ->
            val pixels = pool.acquire()
            pixels.put(pattern(role, number, rowBytes * height)).flip()
            ImageSample.Plane(role, pixels)
        }
        return ImageSample(captureNanos, number, rowBytes, height, rowBytes, pose, intrinsics, metadata, planes) {
            planes.forEach { pool.release(it.pixels) }
        }
    }

    override fun close() = Unit

    companion object {
        fun pattern(
            role: String,
            number: Long,
            size: Int,
        ) = ByteArray(size) { (it * 7 + number + role.hashCode()).toByte() }
    }
}
