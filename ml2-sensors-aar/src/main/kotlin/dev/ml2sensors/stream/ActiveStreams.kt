package dev.ml2sensors.stream

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.session.Lane
import dev.ml2sensors.session.SourceFailure
import dev.ml2sensors.session.StreamControl
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.ComposedHeadset
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.Event
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.ReceiveChannel
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.update
import kotlinx.coroutines.joinAll
import kotlinx.coroutines.launch
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import java.util.concurrent.ConcurrentHashMap
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * The streams of one app instance over all its sessions: what is configured, what runs, and the books.
 *
 * @param scope the pipelines' own.
 */
internal class ActiveStreams(
    headset: Headset,
    private val clock: HostClock,
    private val scope: CoroutineScope,
) : StreamControl {
    private class Running(
        val values: StreamValues,
        val frameIds: FrameIds,
        val job: Job,
    )

    private val headset = ComposedHeadset(headset)
    private val waits = headset.timeline == Headset.Timeline.RECORDED
    private val outgoing = OutgoingChannels(waits)
    private val custom = CustomTopics(outgoing, clock.stamps)
    private val accepted = LinkedHashMap<StreamSpec, StreamValues>()
    private var frameIds = FrameIds()
    private val running: MutableMap<StreamSpec, Running> = ConcurrentHashMap()
    private val tree = TransformTree(clock.stamps, isLive = !waits) { events.trySend(it) }

    private val local = LocalStreams(this.headset, scope, ::failedLocally)
    private var isConfigured = false

    private val changes = Mutex()
    private val hasStarted = CompletableDeferred<Unit>()

    /** What became of each stream asked for, by id. */
    val states = MutableStateFlow<Map<String, StreamState>>(emptyMap())

    override val failures: Channel<SourceFailure> = Channel(Channel.UNLIMITED)

    override val events: Channel<Event> = Channel(Channel.UNLIMITED)

    override val additions: ReceiveChannel<Unit> get() = custom.additions

    override val drainLimit: Duration = if (waits) Duration.INFINITE else 2.seconds

    override val timestampBases: Map<String, String>
        get() = headset.timestampBases.mapValues { (_, base) -> base.wireName }

    override val thermal: String? get() = headset.thermal?.wireName

    override val capabilities: List<String>
        get() = StreamTable.all.filter { headset.negotiate(it, it.defaultValues()) !is Answer.Refused }.map { it.id }

    /** As [Ml2Streamer.publisher]. */
    fun publisher(name: String, type: String): TopicPublisher = custom.publisher(name, type)

    override fun refuse(channel: Int, reason: String): Unit = custom.refuse(channel, reason)

    override fun linkUp(received: Map<String, Long>?) {
        custom.linkUp()
        if (received != null) outgoing.settle(received)
    }

    override suspend fun configure(requested: Map<String, StreamValues>, framePrefix: String): Map<String, Answer> {
        val answers = requested.mapValues { (id, values) ->
            StreamTable.byId(id)?.let { headset.negotiate(it, values) }
                ?: Answer.Refused("this headset knows no stream $id")
        }
        changes.withLock {
            isConfigured = true
            local.end()
            frameIds = FrameIds(framePrefix)
            accepted.clear()
            for ((id, answer) in answers) {
                answer.acceptedValues?.let {
                    accepted[checkNotNull(StreamTable.byId(id))] = it
                }
            }
            val changed = running.filter { (spec, it) -> accepted[spec] != it.values || it.frameIds != frameIds }
            changed.forEach { (spec, it) ->
                it.job.cancelAndJoin()
                forget(spec)
            }
            states.value = answers.mapValues { (_, answer) -> answer.toState() }
            custom.refusal = answers[StreamTable.custom.id].customRefusal()
        }
        return answers
    }

    /** Runs [wanted] without sending it anywhere, until the first CONFIGURE of this instance. */
    suspend fun runLocally(wanted: Map<String, StreamValues>): Unit = changes.withLock {
        if (!isConfigured && states.value.isEmpty()) states.value = local.begin(wanted)
    }

    private suspend fun failedLocally(spec: StreamSpec, cause: Exception): Unit = changes.withLock {
        tellFailure(spec, reason(cause))
    }

    /** To be called with the lock on changes, or what is being begun would say that it runs. */
    private fun tellFailure(spec: StreamSpec, reason: String) {
        states.update { it + (spec.id to StreamState.Failed(reason)) }
    }

    private suspend fun forget(spec: StreamSpec) {
        running.remove(spec)
        if (spec == StreamTable.tf) tree.end() else tree.forget(spec)
    }

    override suspend fun channels(): List<ChannelBody> =
        changes.withLock {
            accepted.flatMap { (spec, values) -> channels(spec, values).map { it.describe(spec, frameIds) } }
        }

    private fun channels(spec: StreamSpec, values: StreamValues): List<OutgoingChannel> =
        if (spec == StreamTable.custom) custom.channels() else outgoing.of(spec, values)

    override fun lane(name: String): Lane = outgoing.lane(name)

    override suspend fun start(known: Set<Int>) {
        val link = custom.link
        val wanted = changes.withLock { accepted.toMap() }
        scope.launch {
            clock.awaitStamps()
            if (waits) clock.freeze()
            changes.withLock {
                // What was configured in the meantime has a START of its own
                val fresh = wanted.filter { (spec, values) -> accepted[spec] == values && spec !in running }
                // The tree first, so that no image comes before it, and nothing that is new is said twice
                val (tf, others) = fresh.entries.partition { it.key == StreamTable.tf }
                tf.forEach { (spec, values) -> begin(spec, values) }
                tree.repeat()
                others.forEach { (spec, values) -> begin(spec, values) }
                if (StreamTable.custom in running) custom.open(link, known)
            }
            hasStarted.complete(Unit)
        }
    }

    private suspend fun begin(
        spec: StreamSpec,
        values: StreamValues,
    ) {
        if (spec == StreamTable.tf) tree.begin(outgoing.of(spec, values), frameIds)
        val frameIds = frameIds
        running[spec] = Running(values, frameIds, scope.launch { run(spec, values, frameIds) })
    }

    override suspend fun stopSources(): Unit =
        changes.withLock {
            isConfigured = true
            local.end()
            accepted.clear()
            running.values.forEach { it.job.cancelAndJoin() }
        }

    override fun counts(): Map<String, Status.ChannelCounts> = outgoing.counts()

    /** Waits until all that a recording holds has been delivered; live sensors never end. */
    suspend fun awaitEnd(): String {
        hasStarted.await()
        if (!waits) awaitCancellation()
        changes.withLock { running.values.map { it.job } }.joinAll()
        return "the recording is over"
    }

    private suspend fun run(
        spec: StreamSpec,
        values: StreamValues,
        frameIds: FrameIds,
    ) {
        try {
            pipeline(spec, values, frameIds)
        } catch (e: CancellationException) {
            throw e
        } catch (e: Exception) {
            val reason = reason(e)
            changes.withLock {
                accepted.remove(spec)
                forget(spec)
                tellFailure(spec, reason)
            }
            failures.send(SourceFailure(spec.id, reason))
        }
    }

    private suspend fun pipeline(
        spec: StreamSpec,
        values: StreamValues,
        frameIds: FrameIds,
    ) {
        if (spec == StreamTable.custom) return custom.run()
        val samples = headset.samples(spec, values)
        val channels = outgoing.of(spec, values)
        when {
            spec == StreamTable.tf -> samples.collect(tree::head)

            spec.modes.isNotEmpty() ->
                CameraPipeline(spec, channels, clock.stamps, tree, frameIds).run(samples)

            else -> MeasurementPipeline(spec, values, channels.single(), clock.stamps, frameIds).run(samples)
        }
    }
}

private fun reason(cause: Exception) = "${cause.javaClass.simpleName}: ${cause.message}"
