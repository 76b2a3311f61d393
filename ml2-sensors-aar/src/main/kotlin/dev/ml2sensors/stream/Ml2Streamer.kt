package dev.ml2sensors.stream

import dev.ml2sensors.Version
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.message.ServiceType
import dev.ml2sensors.ros.Keep
import dev.ml2sensors.ros.Received
import dev.ml2sensors.ros.ServiceClient
import dev.ml2sensors.ros.ServiceClients
import dev.ml2sensors.ros.ServiceServer
import dev.ml2sensors.ros.ServiceServers
import dev.ml2sensors.ros.StampedPose
import dev.ml2sensors.ros.SubscriptionException
import dev.ml2sensors.ros.Subscriptions
import dev.ml2sensors.session.AllOpenings
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.Session
import dev.ml2sensors.session.toBody
import dev.ml2sensors.session.unlessStopped
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.CancellationException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineExceptionHandler
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.cancel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.StateFlow
import kotlinx.coroutines.flow.asStateFlow
import kotlinx.coroutines.launch
import kotlinx.coroutines.withTimeoutOrNull
import kotlinx.serialization.KSerializer
import java.io.IOException
import java.nio.ByteBuffer
import java.util.UUID
import java.util.concurrent.atomic.AtomicBoolean
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/**
 * Streams the sensors of [headset] that the receiver requests to [receiver], and reconnects whenever the connection is
 * lost, until stopped. One streamer is one instance in the sense of PROTOCOL.md and is started once. Thread-safe; it
 * runs on threads of its own.
 *
 * @param security of all connections; [TransportSecurity.Insecure] refuses eye images unless it allows them.
 * @param localDefaults streams by id that run for readers on the headset, after the first attempt without a receiver
 * until one sends its configuration; empty values mean the stream's defaults.
 */
public class Ml2Streamer(
    private val headset: Headset,
    private val receiver: Receiver,
    private val security: TransportSecurity,
    private val localDefaults: Map<String, StreamValues> = emptyMap(),
) {
    private val failing = CoroutineExceptionHandler { _, error -> fail(error) }
    private val scope = CoroutineScope(SupervisorJob() + Dispatchers.Default + failing)
    private val hostClock = HostClock(headset.clock)
    private val active = ActiveStreams(headset.withoutUnprotectedEyeImages(security), hostClock, scope)
    private val subscriptions = Subscriptions()
    internal val clients = ServiceClients()
    internal val servers = ServiceServers()
    private val stopReason = CompletableDeferred<String>()
    private val mutableState = MutableStateFlow<StreamerState>(StreamerState.Connecting(reason = null))
    private val instanceId = UUID.randomUUID().toString()
    private var running: Job? = null

    /** The state of the connection. */
    public val state: StateFlow<StreamerState> = mutableState.asStateFlow()

    /** The state of each stream that the receiver requested, by the ids of the stream table. */
    public val streams: StateFlow<Map<String, StreamState>> = active.states

    /**
     * Returns the publisher of the app's own topic `custom/[name]` with messages of a ROS [type] such as
     * `std_msgs/msg/Float32`; the same one for the same name. Topics can be added before and after [start], and exist
     * as long as the streamer. An absolute name, such as `/cmd_vel`, is published as it is, if the receiver's user
     * allows it (`app.publish`); [TopicPublisher.refusal] says if not. What follows needs such a receiver, too:
     *
     * @param isLatched keeps the newest message for subscribers that come later (transient local).
     * @param isLarge lets messages have up to 16 MiB. They give way to sensors, as images do.
     * @param will what the receiver publishes when the app falls silent.
     * @throws IllegalArgumentException if ROS does not allow the name or type, or the topic was made otherwise.
     * @throws IllegalStateException if there are already 32, the most for one run of the app.
     */
    public fun publisher(
        name: String,
        type: String,
        isLatched: Boolean = false,
        isLarge: Boolean = false,
        will: Will? = null,
    ): TopicPublisher = active.publisher(name, type, isLatched, isLarge, will)

    /**
     * Receives the messages of a ROS [topic] while the flow is collected. The receiver's user has to allow the topic
     * (`app.subscribe`). Messages of before [start] and of outages do not come, except those that the topic keeps for
     * late subscribers; such come again after each outage. No other message comes twice. The flow ends with the
     * streamer. Each collector has a subscription of its own, at most 64 at a time, and decodes in its own coroutine.
     * A message of more than 64 KiB, or of more than 16 MiB if its type has a sequence of bytes or of messages, and one
     * that is not CDR of the type, is left out and counted.
     *
     * @param serializer of a class as [Cdr] describes it, whose `@SerialName` is the ROS type, such as
     * `sensor_msgs/msg/JointState`. The receiver compares the order and types of the fields with those of the ROS type.
     * @param keep the messages that wait for a collector that is slower than the topic.
     * @param maxHz the greatest rate at which the receiver sends messages; it leaves out others. Null has no bound.
     * @param hash of the type, such as `RIHS01_df66…`, by which the receiver also compares versions of the type. A type
     * with so many fields that their layout does not fit into an OPEN is compared by its hash alone.
     * @return a flow that fails with [SubscriptionException] if the receiver refuses the topic or withdraws it. The loss
     * of the connection does not end it.
     * @throws IllegalArgumentException if the class is not named after a ROS type, has no CDR, or needs a [hash].
     */
    public fun <T> subscribe(
        topic: String,
        serializer: KSerializer<T>,
        keep: Keep = Keep.Latest,
        maxHz: Double? = null,
        hash: String? = null,
    ): Flow<Received<T>> = subscriptions.subscribe(topic, serializer, keep, maxHz, hash)

    /**
     * As the other one, for a [type] without a class: a message is its CDR, encapsulation header included. Bytes may
     * follow behind the message. The receiver cannot compare the fields without a [hash].
     */
    public fun subscribe(
        topic: String,
        type: String,
        keep: Keep = Keep.Latest,
        maxHz: Double? = null,
        hash: String? = null,
    ): Flow<Received<ByteBuffer>> = subscriptions.subscribe(topic, type, keep, maxHz, hash)

    /**
     * Receives the pose of [frame] in [reference] while the flow is collected, from the transforms of ROS. The
     * receiver's user has to allow `/tf` (`app.subscribe`). Nothing comes while no transforms connect the frames, and
     * while the pose does not change. A slow collector gets the newest pose alone. Otherwise the flow is as that of
     * [subscribe].
     *
     * @param maxHz the greatest rate; the receiver sends 120 poses per second at most.
     * @return a flow that fails with [SubscriptionException] if the receiver refuses the transforms or withdraws them.
     */
    public fun transform(frame: String, reference: String, maxHz: Double? = null): Flow<StampedPose> =
        subscriptions.transform(frame, reference, maxHz)

    /**
     * Returns a client of a [service] of ROS, such as `client("/pause", SetBool)`. The receiver's user has to allow the
     * service (`app.call`).
     *
     * @throws IllegalArgumentException if ROS does not allow the type's name, or its classes have no CDR.
     */
    public fun <Q, A> client(service: String, type: ServiceType<Q, A>): ServiceClient<Q, A> =
        clients.client(service, type)

    /**
     * Offers a service [name] to nodes of ROS until it is closed, such as
     * `service("custom/stop", Trigger) { Trigger.Response(true, "") }`. A relative name is below the headset's prefix in
     * ROS. The receiver's user has to allow it: by `custom.enabled` below `custom/`, else by `app.offer`.
     *
     * @param answer returns the response to a request. Requests are answered at the same time, by up to 64 threads that
     * may block. It is cancelled when the answer is not waited for any more: after 10 s, or with the connection. If it
     * throws, or the response has more than 64 KiB, the caller gets a failure.
     * @throws IllegalArgumentException if ROS does not allow the type's name, or its classes have no CDR.
     */
    public fun <Q, A> service(name: String, type: ServiceType<Q, A>, answer: suspend (Q) -> A): ServiceServer =
        servers.offer(name, type, answer)

    /**
     * Returns the ROS time in ns of what was captured at [captureNanos] on the headset's clock, for the header of a
     * message; all messages of that time have the same stamp. Null while it is unknown, after a backward step of ROS
     * time, and for a time more than a second ahead.
     */
    public fun stampNanos(captureNanos: Long): Long? =
        if (hostClock.stamps.isSet) hostClock.stamps.stampNanos(captureNanos) else null

    /** Returns the present status; [receiver] names the receiver until its own name is known. */
    public fun status(receiver: String = ""): StreamerStatus = StreamerStatus.of(this, receiver)

    /** Returns the current counters, as in STATUS. */
    internal fun counts(): Map<String, Status.ChannelCounts> = active.reports.counts()

    /** As [Headset.holds]. */
    internal val holds: Map<String, String> get() = active.holds

    internal fun clock(): Status.Clock = hostClock.toBody(active.reports.timestampBases)

    /** Starts connecting. */
    @Synchronized
    public fun start() {
        check(running == null) { "this streamer was started before; make a new one to start again" }
        if (isWarm.compareAndSet(false, true)) active.warming = scope.launch { warmUp() }
        running = scope.launch {
            val ending = launch { stopReason.complete(active.awaitEnd()) }
            val reporting = launch { headset.reportSuspends(active.reports.events) }
            try {
                stayConnected()
            } catch (e: Error) {
                fail(e)
            }
            ending.cancel()
            reporting.cancel()
            active.stopSources()
            ended()
        }
    }

    /** Ends the streamer with [error] as the reason; an unexpected exception never ends the app. */
    private fun fail(error: Throwable) {
        stopReason.complete("failed: ${error.javaClass.simpleName}: ${error.message}")
    }

    /**
     * Stops the sources, sends what they have delivered, sends [reason] to the receiver, and returns when everything
     * has ended, after [STOP_LIMIT] and [ABORT_LIMIT] at most.
     */
    public suspend fun stop(reason: String = "stopped") {
        stopReason.complete(reason)
        synchronized(this) { running }?.let { job ->
            withTimeoutOrNull(STOP_LIMIT) { job.join() }
            job.cancel()
            withTimeoutOrNull(ABORT_LIMIT) { job.join() }
        }
        scope.cancel()
        ended()
    }

    private suspend fun ended() {
        active.endTopics()
        mutableState.value = StreamerState.Ended(stopReason.await())
        subscriptions.end()
        clients.end()
        servers.end()
    }

    private suspend fun stayConnected() {
        val backOff = BackOff()
        while (!stopReason.isCompleted) {
            backOff.begin()
            var welcomed: TimeMark? = null
            try {
                val address = unlessStopped(stopReason) { receiver.locate() } ?: break
                session(address).run(hello(), stopReason) { name ->
                    welcomed = TimeSource.Monotonic.markNow()
                    mutableState.value = StreamerState.Connected(name)
                }
            } catch (e: CancellationException) {
                throw e
            } catch (e: Exception) {
                val name = e.javaClass.simpleName
                val reason = if (e is IOException) e.message ?: name else "$name: ${e.message}"
                mutableState.value = StreamerState.Connecting(reason)
                active.runLocally(localDefaults)
                // A receiver that breaks each session at once is no better than none
                if (welcomed?.let { it.elapsedNow() > LASTING } == true) backOff.succeeded()
                withTimeoutOrNull(backOff.pause()) { stopReason.await() }
            }
        }
    }

    private fun session(receiver: ReceiverAddress) = Session(
        receiver,
        security,
        headset.clock,
        hostClock,
        active,
        app = AllOpenings(subscriptions, clients, servers),
    )

    private fun hello() = Hello(
        listOf(FrameHeader.VERSION),
        headset.identity.deviceId,
        instanceId,
        headset.identity.name,
        software = "ml2-sensors ${Version.NAME}",
        Hello.Capabilities(active.capabilities, ros = true),
        headset.permissions,
        active.reports.counts(),
    )

    private companion object {
        val STOP_LIMIT = 8.seconds

        /** After a session that lasted longer, the next one may follow as soon as if it were the first. */
        val LASTING = 2.seconds

        /** For the end of what was cancelled; longer than streams take to stop. */
        val ABORT_LIMIT = 5.seconds

        /** True once this process has warmed up. */
        val isWarm = AtomicBoolean()
    }
}
