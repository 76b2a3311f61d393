package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.TransformStamped
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.times
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.HeadPose
import dev.ml2sensors.source.HeadTrack
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.MapSample
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock

/**
 * Publishes `/tf` and `/tf_static`: transforms at 60 Hz, and one with the exact stamp of each image. Any stream may
 * call it; it runs between [begin] and [end].
 *
 * In the flat layout every frame is a child of the world. The sensors' poses at 60 Hz are the head's pose composed with
 * their mountings. In the rig layout, which its channels have if one has the role `tf_static`, only the head moves; the
 * sensors are its children, and give its pose at their images, once their mountings are stable.
 *
 * While the head is not tracked nothing is sent. A camera's pose waits for the next head pose, since the device repeats
 * the old pose while tracking is lost. There is at most one transform per child and stamp.
 *
 * @param isLive false for a recording, whose poses are sent as they are.
 */
internal class TransformTree(
    private val stamps: StampMap,
    private val isLive: Boolean,
    private val trackingEvents: TrackingEvents,
    private val report: (Event) -> Unit,
) {
    private class CameraPose(val spec: StreamSpec, val captureNanos: Long, val stampNanos: Long?, val pose: Transform)

    private val mutex = Mutex()
    private val track = HeadTrack()
    private val mountings = LinkedHashMap<StreamSpec, SensorMounting>()
    private val pending = ArrayDeque<CameraPose>()
    private val lastStamps = HashMap<String, RecentStamps>()

    @Volatile
    private var dynamic: TopicChannel? = null
    private var static: TopicChannel? = null
    private var staticStampNanos = 0L
    private var frameIds = FrameIds()

    suspend fun begin(channels: List<TopicChannel>, frameIds: FrameIds): Unit = mutex.withLock {
        this.frameIds = frameIds
        dynamic = channels.single { it.topic.role == "tf" }
        static = channels.singleOrNull { it.topic.role == "tf_static" }
    }

    suspend fun end(): Unit = mutex.withLock {
        dynamic = null
        static = null
        track.clear()
        pending.clear()
    }

    /** Starts a new track of the head: the next pose is not connected to earlier ones. */
    suspend fun beginTrack(): Unit = mutex.withLock { track.clear() }

    /** Adds a sample of the head. */
    suspend fun head(sample: Sample) {
        when (sample) {
            is PoseSample -> inSession {
                if (stamps.isFuture(sample.captureNanos)) return lose(1, stamps.lossReason(sample.captureNanos))
                trackingEvents.add(sample)
                track.add(sample)
                processPending()
                sample.pose?.let { publish(sample.captureNanos, stamps.stampNanos(sample.captureNanos), framesAt(it)) }
            }

            is LostSamples -> mutex.withLock {
                if (sample.count > HeadTrack.MAX_BRIDGED) track.lose()
                lose(sample.count, sample.reason)
            }

            else -> error("the head delivered $sample")
        }
    }

    /** Adds the [pose] of a camera at a capture; [stampNanos] is null if the stamp is withheld. */
    suspend fun camera(spec: StreamSpec, captureNanos: Long, stampNanos: Long?, pose: Transform): Unit =
        inSession {
            if (dynamic == null) return
            if (stamps.isFuture(captureNanos)) return lose(1, stamps.lossReason(captureNanos))
            if (!isLive) return publish(captureNanos, stampNanos, framesOf(spec, pose))
            pending.addLast(CameraPose(spec, captureNanos, stampNanos, pose))
            processPending()
            if (pending.size > MAX_PENDING) {
                pending.removeFirst()
                lose(1, DropReason.SOURCE_LATE)
            }
        }

    /** Adds a sample of the controller, which is a child of the world in both layouts. */
    suspend fun controller(sample: PoseSample): Unit =
        sample.pose?.let { children(sample.captureNanos, listOf(frameIds.of(StreamTable.controllerJoy) to it)) } ?: Unit

    /** Adds the markers that are tracked, which are children of the world in both layouts. */
    suspend fun markers(sample: MarkersSample) {
        if (sample.markers.isEmpty()) return
        children(sample.captureNanos, sample.markers.map { frameIds.ofMarker(it.frame) to it.pose })
    }

    /** Adds the map, which is the parent of the world in both layouts. */
    suspend fun map(sample: MapSample) {
        val world = sample.origin?.inverse() ?: return
        children(sample.captureNanos, listOf(frameIds.world to world), parent = frameIds.of(StreamTable.map))
    }

    private suspend fun children(
        captureNanos: Long,
        frames: List<Pair<String, Transform>>,
        parent: String = frameIds.world,
    ): Unit = inSession {
        if (stamps.isFuture(captureNanos)) return lose(1, stamps.lossReason(captureNanos))
        publish(captureNanos, stamps.stampNanos(captureNanos), frames, parent)
    }

    /**
     * Runs [block] with the lock. A recording waits for a session first, but never with the lock: a receiver that
     * returns configures the streams before it starts them.
     */
    private suspend inline fun inSession(block: () -> Unit) {
        if (!isLive) awaitSession()
        mutex.withLock { block() }
    }

    private suspend fun awaitSession() {
        try {
            dynamic?.lane?.awaitSession()
        } catch (e: CancellationException) {
            lose(1, DropReason.LINK_DOWN)
            throw e
        }
    }

    private fun lose(count: Int, reason: DropReason) {
        dynamic?.counters?.countLost(count, reason)
    }

    /** Removes a camera that has stopped. */
    suspend fun remove(spec: StreamSpec): Unit = mutex.withLock {
        pending.removeIf { it.spec == spec }
        if (mountings.remove(spec)?.stable != null) sendMountings()
    }

    /** Sends the mountings again, for a new receiver. */
    suspend fun resendMountings(): Unit = mutex.withLock {
        if (mountings.values.any { it.stable != null }) sendMountings()
    }

    private suspend fun processPending() {
        val processed = pending.filter { frame ->
            val head = track.at(frame.captureNanos)
            if (head is HeadPose.Tracked) publishAt(frame, head)
            if (head is HeadPose.Lost) lose(1, DropReason.SOURCE_LATE)
            head != HeadPose.NotYetKnown
        }
        pending.removeAll(processed)
    }

    private suspend fun publishAt(frame: CameraPose, head: HeadPose.Tracked) {
        // No mounting is better than a wrong one: the poses at 60 Hz are composed with it.
        if (!head.isBridged) addMounting(frame, head.pose)
        if (static == null) return publish(frame.captureNanos, frame.stampNanos, framesOf(frame.spec, frame.pose))
        // Before that nobody can look the camera up
        val stable = mountings[frame.spec]?.stable ?: return
        publish(frame.captureNanos, frame.stampNanos, listOf(frameIds.head to frame.pose * stable.inverse()))
    }

    private suspend fun addMounting(frame: CameraPose, head: Transform) {
        val mounting = mountings.getOrPut(frame.spec, ::SensorMounting)
        val residual = mounting.add(head.inverse() * frame.pose) ?: return
        val text = "the mounting of ${frame.spec} is stable over its last ${SensorMounting.WINDOW} frames: $residual"
        report(Event(Event.MOUNTING_STABLE, text))
        staticStampNanos = frame.stampNanos ?: staticStampNanos
        sendMountings()
    }

    private fun framesAt(head: Transform): List<Pair<String, Transform>> {
        val sensors = if (static == null) mountings else emptyMap()
        return sensors.flatMap { (spec, it) -> framesOf(spec, head * it.latest) } + (frameIds.head to head)
    }

    private fun framesOf(spec: StreamSpec, optical: Transform): List<Pair<String, Transform>> =
        listOf(frameIds.of(spec) to optical, frameIds.bodyOf(spec) to optical * BODY_IN_OPTICAL)

    private suspend fun publish(
        captureNanos: Long,
        stampNanos: Long?,
        frames: List<Pair<String, Transform>>,
        parent: String = frameIds.world,
    ) {
        if (stampNanos == null) return lose(1, stamps.lossReason(captureNanos))
        val header = Header(Time.ofNanos(stampNanos), parent)
        val fresh = frames.filter { (child, _) -> lastStamps.getOrPut(child, ::RecentStamps).add(stampNanos) }
        if (fresh.isEmpty()) return
        val message = TFMessage(fresh.map { (child, transform) -> TransformStamped(header, child, transform) })
        dynamic?.let { it.lane.offerIfInSession(it.frame(TFMessage.serializer(), message, stampNanos, sample = null)) }
    }

    private suspend fun sendMountings() {
        val stamp = Time.ofNanos(staticStampNanos)
        val transforms = mountings.flatMap { (spec, mounting) ->
            val body = frameIds.bodyOf(spec)
            mounting.stable?.let {
                listOf(
                    TransformStamped(Header(stamp, frameIds.head), body, it * BODY_IN_OPTICAL),
                    TransformStamped(Header(stamp, body), frameIds.of(spec), OPTICAL_IN_BODY),
                )
            }.orEmpty()
        }
        // Two streams of one camera share its frames
        val message = TFMessage(transforms.distinctBy { it.childFrameId })
        static?.publish(TFMessage.serializer(), message, staticStampNanos)
    }

    private companion object {
        val BODY_IN_OPTICAL = OPTICAL_IN_BODY.inverse()

        /** Half a second of five cameras; the next head pose arrives within 17 ms. */
        const val MAX_PENDING = 75
    }
}

/** The latest stamps of one child, enough to detect a repetition, since streams deliver in order. */
private class RecentStamps {
    private val stamps = LongArray(64) { Long.MIN_VALUE }
    private var next = 0

    /** Adds [stampNanos]; returns false if it is already there. */
    fun add(stampNanos: Long): Boolean {
        if (stampNanos in stamps) return false
        stamps[next] = stampNanos
        next = (next + 1) % stamps.size
        return true
    }
}
