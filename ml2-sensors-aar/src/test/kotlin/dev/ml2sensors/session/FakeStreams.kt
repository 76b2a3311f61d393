package dev.ml2sensors.session

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.LaneClass
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.update
import java.nio.ByteBuffer
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CopyOnWriteArrayList
import kotlin.test.assertTrue
import kotlin.time.Duration

/**
 * In-memory streams: each has a topic `<stream>/image` on its own lane and `<stream>/info` on `sensors`. The stream
 * `absent` is refused. Messages are made by [offer].
 */
internal class FakeStreams(override val drainLimit: Duration = TEST_LIMIT) :
    StreamControl,
    StreamReports {
    private val lanes = ConcurrentHashMap<String, Lane>()
    private val countersByTopic = ConcurrentHashMap<String, ChannelCounters>()
    private val ids = listOf("world_left", "color", "depth").flatMap { listOf("$it/image", "$it/info") }
    private val accepted = CopyOnWriteArrayList<String>()

    /** CONFIGURE is handled as soon as this is complete. */
    @Volatile
    var configuring = CompletableDeferred(Unit)

    /** The calls of the session, in order. */
    val calls = MutableStateFlow(emptyList<String>())

    override val reports get() = this
    val capabilities = listOf("world_left", "color", "depth")
    override val thermal = "light"
    override val timestampBases = mapOf("color" to "monotonic")
    override val streamStates get() = states
    override val conditions =
        mapOf("tracking" to Status.Condition.of(false, "not tracked", mapOf("status" to "invalid")))
    override val stateChanges = Channel<Unit>(Channel.CONFLATED)

    @Volatile
    private var states = emptyMap<String, Status.Stream>()
    override val failures = Channel<SourceFailure>(Channel.UNLIMITED)
    override val events = EventQueue()

    override fun beginSession(received: Map<String, Long>?, servesApps: Boolean) {
        call("beginSession $received")
        if (received != null) countersByTopic.forEach { (topic, counters) -> counters.reconcile(received[topic] ?: 0) }
    }

    override suspend fun configure(
        requested: Map<String, StreamValues>,
        framePrefix: String,
        adapts: Boolean,
    ): Map<String, Answer> {
        call("configure ${requested.keys}")
        configuring.await()
        accepted.clear()
        accepted += requested.keys - "absent"
        return requested.mapValues { (id, values) ->
            if (id == "absent") Answer.Refused("not there") else Answer.Adjusted(values.copy(rateHz = 5), "5 Hz is all")
        }
    }

    override suspend fun adaptTo(pacing: ImagePacing): Unit = awaitCancellation()

    fun call(what: String) = calls.update { it + what }

    override suspend fun channels(): List<ChannelBody> =
        accepted.flatMap { listOf(body(it, "image", it), body(it, "info", "sensors")) }

    private fun body(stream: String, role: String, lane: String): ChannelBody {
        val topic = "$stream/$role"
        return ChannelBody(ids.indexOf(topic) + 1, stream, role, topic, "some/msg/Type", "image", "frame", lane)
    }

    override fun lane(name: String): Lane = lanes.computeIfAbsent(name) {
        Lane(it, laneClass(100, isPaced = it != "sensors"), suspendsWhenFull = false)
    }

    override suspend fun start(known: Set<Int>) {
        call("start")
    }

    override fun refuse(channel: Int, reason: String) = call("refuse $channel $reason")

    override val additions = Channel<Unit>(Channel.CONFLATED)

    /** The source of [stream] fails. */
    fun fail(stream: String, reason: String) {
        accepted -= stream
        assertTrue(failures.trySend(SourceFailure(stream, reason)).isSuccess)
    }

    /** [states] are how the streams stand now. */
    fun turn(states: Map<String, Status.Stream>) {
        this.states = states
        stateChanges.trySend(Unit)
    }

    override suspend fun stopSources() {
        call("stopSources")
    }

    override fun counts(): Map<String, Status.ChannelCounts> = countersByTopic.mapValues { (_, it) -> it.snapshot() }

    suspend fun offer(topic: String, payloadBytes: Int = 8) {
        val counters = countersByTopic.computeIfAbsent(topic) { ChannelCounters() }
        val head = ByteBuffer.allocate(FrameHeader.BYTES + payloadBytes)
        FrameHeader(FrameKind.DATA.code, payloadBytes, ids.indexOf(topic) + 1, counters.nextSequence()).writeTo(head)
        head.put(byteArrayOf(0, 1, 0, 0)).rewind()
        val lane = if (topic.endsWith("/info")) "sensors" else topic.substringBefore('/')
        lane(lane).offer(OutgoingFrame(counters, head, data = null, sample = null))
    }
}

internal fun laneClass(queueFrames: Int, isPaced: Boolean = false): LaneClass =
    LaneClass("test", isShared = false, isPaced, queueFrames, maxPayloadBytes = 16 shl 20)
