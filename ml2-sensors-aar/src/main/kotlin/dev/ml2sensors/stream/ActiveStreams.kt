package dev.ml2sensors.stream

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.session.EventQueue
import dev.ml2sensors.session.Lane
import dev.ml2sensors.session.SourceFailure
import dev.ml2sensors.session.StreamControl
import dev.ml2sensors.session.blockingThreads
import dev.ml2sensors.session.imageThreads
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DerivedStreamsHeadset
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.ChannelBody
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.CoroutineDispatcher
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
import kotlinx.coroutines.channels.ReceiveChannel
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.flow.StateFlow
import kotlinx.coroutines.job
import kotlinx.coroutines.launch
import kotlinx.coroutines.plus
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import java.util.concurrent.ConcurrentHashMap
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * The streams of one app instance over all its sessions: what is configured, what runs, and the counters.
 *
 * @param scope runs the pipelines.
 * @param sources returns threads that run streams, of images or not, whose sources may block.
 */
internal class ActiveStreams(
    headset: Headset,
    private val clock: HostClock,
    private val scope: CoroutineScope,
    private val sources: (ofImages: Boolean) -> CoroutineDispatcher = { if (it) imageThreads else blockingThreads },
) : StreamControl {
    private class Running(
        val values: StreamValues,
        val frameIds: FrameIds,
        val job: Job,
    )

    private val streamScope = scope + sources(false)
    private val stopping = StoppingStreams()

    private val headset = DerivedStreamsHeadset(headset)
    private val streams = StreamStates(this.headset)
    private val isRecording = headset.timeline == Headset.Timeline.RECORDED
    private val outgoing = TopicChannels(isRecording)
    private val custom = CustomTopics(outgoing, clock.stamps)
    private val accepted = LinkedHashMap<StreamSpec, StreamValues>()
    private var frameIds = FrameIds()
    private val running: MutableMap<StreamSpec, Running> = ConcurrentHashMap()
    private val events = EventQueue()
    private val trackingEvents = TrackingEvents(events::add)
    private val conditions = Conditions(events::add)
    private val tree = TransformTree(clock.stamps, isLive = !isRecording, trackingEvents, events::add)
    private val headWatch = HeadWatch(this.headset, streamScope, trackingEvents, conditions)

    private val adaptation = ImageAdaptation(outgoing::lane) {
        events.add(it)
        streams.changes.trySend(Unit)
    }
    private val pipelines =
        StreamPipelines(outgoing, clock.stamps, tree, adaptation, this.headset.videoEncoders, conditions, events::add)
    override val reports: DeviceReports = DeviceReports(this.headset, outgoing, streams, adaptation, events, conditions)
    private val local = LocalStreams(this.headset, streamScope, ::setState)

    @Volatile
    private var isConfigured = false
    private var rechecking: Job? = null

    /** The warm-up of the library, which [start] waits for. */
    var warming: Job? = null

    /** Held for changes of what is below and of the states; never while a device or a stream is awaited. */
    private val changes = Mutex()
    private val recordingEnd = RecordingEnd()

    /** The state of each requested stream, by id. */
    val states: StateFlow<Map<String, StreamState>> get() = streams.flow

    /** As [Headset.holds], of derived streams too. */
    val holds: Map<String, String> get() = headset.holds

    override val additions: ReceiveChannel<Unit> get() = custom.additions

    override val drainLimit: Duration = if (isRecording) Duration.INFINITE else 2.seconds

    /** Ids of the streams that can be configured. */
    val capabilities: List<String>
        get() = StreamTable.all.filter { headset.negotiate(it, it.defaultValues()) !is Answer.Refused }.map { it.id }

    /** As [Ml2Streamer.publisher]. */
    fun publisher(name: String, type: String, isLatched: Boolean, isLarge: Boolean, will: Will?): TopicPublisher =
        custom.publisher(name, type, isLatched, isLarge, will)

    override fun refuse(channel: Int, reason: String): Unit = custom.refuse(channel, reason)

    override fun beginSession(received: Map<String, Long>?, servesApps: Boolean) {
        custom.beginSession(servesApps)
        if (received != null) outgoing.reconcile(received)
    }

    override suspend fun configure(
        requested: Map<String, StreamValues>,
        framePrefix: String,
        adapts: Boolean,
    ): Map<String, Answer> {
        val answers = requested.mapValues { (id, values) ->
            StreamTable.byId(id)?.let { headset.negotiate(it, values) }
                ?: Answer.Refused("this headset has no stream $id")
        }
        val changed = changes.withLock {
            isConfigured = true
            rechecking?.cancel()
            headWatch.end()
            frameIds = FrameIds(framePrefix)
            accepted.clear()
            for ((id, answer) in answers) {
                answer.acceptedValues?.let {
                    accepted[checkNotNull(StreamTable.byId(id))] = it
                }
            }
            running.filter { (spec, it) -> accepted[spec] != it.values || it.frameIds != frameIds }
        }
        stopping.end(local.take() + changed.mapValues { (_, it) -> it.job })
        changes.withLock {
            changed.keys.forEach { remove(it) }
            val images = accepted.mapNotNull { (spec, values) ->
                StreamPipelines.imageSetting(spec, values)?.let { spec.id to it }
            }
            adaptation.configure(images.toMap(), adapts && !isRecording)
            custom.refusal = answers[StreamTable.custom.id].customRefusal()
            streams.setAnswers(answers, running.keys)
            if (!isRecording) {
                val refused = requested.filterKeys { answers[it] is Answer.Refused }
                rechecking = streamScope.launch {
                    val own = currentCoroutineContext().job
                    headset.recheck(refused) { if (own.isActive) streams.available = it }
                }
            }
        }
        return answers
    }

    override suspend fun adaptTo(pacing: ImagePacing): Unit = adaptation.adaptTo(pacing)

    /** Runs [configured] without sending anything, until the first CONFIGURE of this instance. */
    suspend fun runLocally(configured: Map<String, StreamValues>) {
        if (isConfigured || streams.flow.value.isNotEmpty()) return
        val asked = local.ask(configured)
        changes.withLock {
            if (!isConfigured && streams.flow.value.isEmpty()) streams.setStates(local.begin(asked))
        }
    }

    /** Sets the state of a stream under the lock, so that it is not set before its start is; null means as answered. */
    private suspend fun setState(spec: StreamSpec, state: StreamState?): Unit = changes.withLock {
        streams.setStopped(spec.id, state)
    }

    private suspend fun remove(spec: StreamSpec) {
        running.remove(spec)
        when (spec) {
            StreamTable.tf -> tree.end()
            StreamTable.custom -> custom.close()
            else -> tree.remove(spec)
        }
    }

    override suspend fun channels(): List<ChannelBody> =
        changes.withLock {
            accepted.flatMap { (spec, values) -> channels(spec, values).map { it.describe(spec, frameIds) } }
        }

    private fun channels(spec: StreamSpec, values: StreamValues): List<TopicChannel> =
        if (spec == StreamTable.custom) custom.channels() else outgoing.of(spec, values)

    override fun lane(name: String): Lane = outgoing.lane(name)

    override suspend fun start(known: Set<Int>) {
        val session = custom.session
        val configured = changes.withLock { accepted.toMap() }
        scope.launch {
            warming?.join()
            clock.awaitStamps()
            if (isRecording) clock.freeze()
            changes.withLock {
                headWatch.end()
                // A stream that was configured in the meantime has a START of its own
                val new = configured.filter { (spec, values) -> accepted[spec] == values && spec !in running }
                // The tree first, so that no image comes before it, and nothing that is new is said twice
                val (tf, others) = new.entries.partition { it.key == StreamTable.tf }
                tf.forEach { (spec, values) -> begin(spec, values) }
                tree.resendMountings()
                others.forEach { (spec, values) -> begin(spec, values) }
                if (StreamTable.custom in running) custom.open(session, known)
                if (!isRecording) headWatch.begin(running.keys)
            }
        }
    }

    private suspend fun begin(
        spec: StreamSpec,
        values: StreamValues,
    ) {
        if (spec == StreamTable.tf) tree.begin(outgoing.of(spec, values), frameIds)
        val frameIds = frameIds
        val job = scope.launch(sources(spec.topics.any { it.laneClass.isPaced })) {
            stopping.awaitEnd(spec) { setState(spec, it) }
            val outage = changes.withLock { streams.stopped(spec.id) }
            run(spec, values, frameIds, outage)
        }
        running[spec] = Running(values, frameIds, job)
    }

    override suspend fun stopSources() {
        val jobs = changes.withLock {
            isConfigured = true
            rechecking?.cancel()
            headWatch.end()
            accepted.clear()
            endTopics()
            running.mapValues { (_, it) -> it.job }
        }
        stopping.end(local.take() + jobs)
    }

    /** Closes the app's own topics, with the session. */
    fun endTopics(): Unit = custom.endSession()

    /** Waits until a recording has been delivered completely; returns the reason. Live sensors never end. */
    suspend fun awaitEnd(): String {
        recordingEnd.await()
        return "the recording is over"
    }

    private suspend fun run(
        spec: StreamSpec,
        values: StreamValues,
        frameIds: FrameIds,
        outage: StreamState?,
    ) {
        if (spec == StreamTable.custom) return // The app is its source
        if (isRecording) {
            return playToItsEnd(spec) {
                pipelines.run(spec, values, frameIds, headset.samples(spec, values))
            }
        }
        val supervisor =
            StreamSupervisor.of(spec, headset, clock.stamps::isFuture, outage) { setState(spec, it) }
        supervisor.run({ headset.samples(spec, values) }) { pipelines.run(spec, values, frameIds, it) }
    }

    /** Plays a stream of a recording. A failure is permanent. */
    private suspend fun playToItsEnd(spec: StreamSpec, play: suspend () -> Unit) {
        changes.withLock { recordingEnd.begin(spec) }
        try {
            play()
        } catch (e: CancellationException) {
            throw e
        } catch (e: Exception) {
            changes.withLock {
                accepted.remove(spec)
                remove(spec)
                streams.setStopped(spec.id, StreamState.Failed(e.words()))
            }
            reports.failures.send(SourceFailure(spec.id, e.words()))
        }
        changes.withLock { recordingEnd.end(spec, accepted.keys) }
    }
}
