package dev.ml2sensors.stream

import dev.ml2sensors.Version
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.session.Receiver
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
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.StateFlow
import kotlinx.coroutines.flow.asStateFlow
import kotlinx.coroutines.launch
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.util.UUID
import java.util.concurrent.atomic.AtomicBoolean
import kotlin.time.Duration.Companion.seconds

/**
 * Streams what the receiver asks of [headset] to [receiver], and connects again whenever the link is lost, until
 * stopped. One streamer is one instance in the sense of PROTOCOL.md: it is started once. All methods may be called from
 * any thread; nothing runs on the caller's.
 *
 * @param security of all connections; [TransportSecurity.Insecure] refuses eye images unless it allows them.
 * @param localDefaults by stream id, what runs on the headset, for readers there, from the first attempt that finds no
 * receiver until one says what it wants; empty values are the stream's default ones.
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
    private val stopReason = CompletableDeferred<String>()
    private val mutableState = MutableStateFlow<StreamerState>(StreamerState.Connecting(reason = null))
    private val instanceId = UUID.randomUUID().toString()
    private var running: Job? = null

    /** Where the streamer is between start and end. */
    public val state: StateFlow<StreamerState> = mutableState.asStateFlow()

    /** What became of each stream the receiver asked for, by the ids of the stream table. */
    public val streams: StateFlow<Map<String, StreamState>> = active.states

    /**
     * The app's own topic `custom/[name]`, for messages of a ROS [type] such as `std_msgs/msg/Float32`; the same one
     * for the same name. It may be made before and after [start], and lives as long as the streamer.
     *
     * @throws IllegalArgumentException for what ROS does not allow, or a name that has another type.
     * @throws IllegalStateException when there are as many as a run of the app can have, 32.
     */
    public fun publisher(name: String, type: String): TopicPublisher = active.publisher(name, type)

    /**
     * ROS time, ns, of what was captured at [captureNanos] on the headset's clock: for the header of a message, the
     * same that all messages of that instant have. Null while it is not known, while ROS time stepped back, and for an
     * instant more than a second ahead.
     */
    public fun stampNanos(captureNanos: Long): Long? =
        if (hostClock.stamps.isSet) hostClock.stamps.stampNanos(captureNanos) else null

    /** How it stands now; [receiver] is what the user calls the receiver as long as it does not tell its name. */
    public fun status(receiver: String = ""): StreamerStatus = StreamerStatus.of(this, receiver)

    /** The books of now, as STATUS has them. */
    internal fun counts(): Map<String, Status.ChannelCounts> = active.counts()

    internal fun clock(): Status.Clock = hostClock.toBody(active.timestampBases)

    /** Begins to connect. */
    @Synchronized
    public fun start() {
        check(running == null) { "a streamer is started once" }
        if (isWarm.compareAndSet(false, true)) active.warming = scope.launch { warmUp() }
        running = scope.launch {
            val ending = launch { stopReason.complete(active.awaitEnd()) }
            try {
                stayConnected()
            } catch (e: Error) {
                fail(e)
            }
            ending.cancel()
            active.stopSources()
            mutableState.value = StreamerState.Ended(stopReason.await())
        }
    }

    /** What nobody expects ends the streamer with a reason, and never the app. */
    private fun fail(error: Throwable) {
        stopReason.complete("failed: ${error.javaClass.simpleName}: ${error.message}")
    }

    /**
     * Stops the sources, sends what they have delivered, tells the receiver [reason], and returns when all has ended;
     * after [STOP_LIMIT] it ends without.
     */
    public suspend fun stop(reason: String = "stopped") {
        stopReason.complete(reason)
        synchronized(this) { running }?.let { job ->
            withTimeoutOrNull(STOP_LIMIT) { job.join() }
            job.cancelAndJoin()
        }
        scope.cancel()
        mutableState.value = StreamerState.Ended(stopReason.await())
    }

    private suspend fun stayConnected() {
        val backOff = BackOff()
        while (!stopReason.isCompleted) {
            backOff.begin()
            try {
                val address = unlessStopped(stopReason) { receiver.locate() } ?: break
                Session(address, security, headset.clock, hostClock, active).run(hello(), stopReason) { name ->
                    backOff.succeeded()
                    mutableState.value = StreamerState.Connected(name)
                }
            } catch (e: CancellationException) {
                throw e
            } catch (e: Exception) {
                val name = e.javaClass.simpleName
                val reason = if (e is IOException) e.message ?: name else "$name: ${e.message}"
                mutableState.value = StreamerState.Connecting(reason)
                active.runLocally(localDefaults)
                withTimeoutOrNull(backOff.pause()) { stopReason.await() }
            }
        }
    }

    private fun hello() = Hello(
        listOf(FrameHeader.VERSION),
        headset.identity.deviceId,
        instanceId,
        headset.identity.name,
        software = "ml2-sensors ${Version.NAME}",
        Hello.Capabilities(active.capabilities),
        headset.permissions,
    )

    private companion object {
        val STOP_LIMIT = 8.seconds

        /** Of this process. */
        val isWarm = AtomicBoolean()
    }
}

/** Where a streamer is. */
public sealed interface StreamerState {
    /** No session; [reason] is why the last one failed or ended, null before the first. */
    public data class Connecting(
        val reason: String?,
    ) : StreamerState

    /** In a session with the receiver that calls itself [receiverName]. */
    public data class Connected(
        val receiverName: String,
    ) : StreamerState

    /** Over, for this [reason]: it was stopped, a recording has come to its end, or the library has failed. */
    public data class Ended(
        val reason: String,
    ) : StreamerState
}
