package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.link.LinkSecurity
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.ChannelEnd
import dev.ml2sensors.wire.Configure
import dev.ml2sensors.wire.Configured
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.LinkTestBody
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Start
import dev.ml2sensors.wire.Status
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.launch
import kotlinx.coroutines.selects.select
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.util.concurrent.ConcurrentLinkedQueue
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * One session from HELLO to its end, on the device's side; PROTOCOL.md, Connecting. Owns the session's connections; the
 * lanes and streams that use them outlive it.
 */
internal class Session(
    private val receiver: ReceiverAddress,
    private val security: LinkSecurity,
    private val deviceClock: DeviceClock,
    private val hostClock: HostClock,
    private val streams: StreamControl,
) {
    private val connections = ConcurrentLinkedQueue<Connection>()
    private val announced = HashSet<Int>()

    /** All CHANNELs that were written, in their order, and how many before the last CONFIGURED. */
    private val written = ArrayList<Int>()
    private var writtenBeforeAnswer = 0
    private val announcing = Mutex()
    private var openRequest: Long? = null

    /**
     * Runs the session until [stop] completes, then ends it in order: everything offered is sent, then the final STATUS,
     * then BYE.
     *
     * @param onWelcome is told the receiver's name.
     * @throws IOException when the session is refused or lost; nothing of it is left running.
     */
    suspend fun run(hello: Hello, stop: Deferred<String>, onWelcome: (String) -> Unit) {
        try {
            val control = ControlLane(unlessStopped(stop) { open(urgent = true) } ?: return)
            try {
                val welcome = unlessStopped(stop) { greet(control, hello) } ?: return
                streams.linkUp(welcome.received)
                onWelcome(welcome.name)
                converse(control, welcome, stop)
            } catch (e: ProtocolException) {
                if (!e.isPeers) control.tell(e)
                throw e
            }
        } finally {
            hostClock.linkDown()
            connections.forEach(Connection::close)
        }
    }

    private suspend fun greet(control: ControlLane, hello: Hello): Welcome {
        control.write(FrameKind.HELLO, hello)
        val frame = handshake("WELCOME", FIRST_LIMIT) { control.read(setOf(FrameKind.WELCOME)) }
        val welcome = ControlJson.decode<Welcome>(frame.body)
        if (welcome.version !in hello.versions) {
            throw ProtocolException(ErrorCode.VERSION, "expected one of ${hello.versions}, found ${welcome.version}")
        }
        welcome.flaw()?.let { throw ProtocolException(ErrorCode.MALFORMED, "WELCOME with $it") }
        return welcome
    }

    private suspend fun converse(control: ControlLane, welcome: Welcome, stop: Deferred<String>) = coroutineScope {
        val lanes = SessionLanes(welcome, ::open, streams::lane) { part(control, it) }
        val timeLane = TimeLane(lanes.joinTime(), deviceClock, hostClock)
        lanes.join(SessionLanes.SENSORS)
        part(control) { timeLane.run() }
        part(control) { control.keepAlive(welcome.timeouts) }
        part(control) { reportFailures(control) }
        part(control) { for (addition in streams.additions) announceAdditions(control) }
        val drained = CompletableDeferred<Unit>()
        val telling = part(control) { reportEvents(control, drained) }
        val statusing = part(control) { reportStatus(control, drained) }
        val reading = part(control) {
            while (true) handle(control.read(IN_SESSION) ?: break, control, lanes)
        }
        val reason = stop.await()
        streams.stopSources()
        lanes.finish(streams.drainLimit)
        drained.complete(Unit)
        telling.join()
        statusing.join()
        control.finish(reason)
        withTimeoutOrNull(ControlLane.FAREWELL_LIMIT) { reading.join() }
        coroutineContext.cancelChildren()
    }

    private suspend fun handle(frame: Frame, control: ControlLane, lanes: SessionLanes) {
        when (frame.kind) {
            FrameKind.CONFIGURE -> configure(ControlJson.decode(frame.body), control, lanes)

            FrameKind.START -> {
                val start = ControlJson.decode<Start>(frame.body)
                checkRequest(start)
                lanes.startSending()
                streams.start(announcing.withLock { written.take(start.channels ?: writtenBeforeAnswer).toSet() })
            }

            FrameKind.LINK_TEST -> lanes.linkTest.begin(ControlJson.decode<LinkTestBody>(frame.body).bytes)

            FrameKind.ERROR -> {
                val error = ControlJson.decode<ErrorBody>(frame.body)
                error.channel?.let { streams.refuse(it, error.message) }
            }

            FrameKind.PING -> control.write(FrameKind.PONG)

            FrameKind.PONG -> Unit

            FrameKind.BYE -> throw IOException("the receiver left: ${ControlJson.decode<Bye>(frame.body).reason}")

            else -> error("${frame.kind} is not allowed in a session")
        }
    }

    private suspend fun configure(wanted: Configure, control: ControlLane, lanes: SessionLanes) {
        val answers = streams.configure(wanted.streams, wanted.framePrefix)
        streams.channels().forEach { lanes.join(it.lane) }
        announcing.withLock {
            val channels = streams.channels()
            endChannelsBut(channels, control)
            announce(channels, control)
            writtenBeforeAnswer = written.size
            openRequest = wanted.request
        }
        control.write(FrameKind.CONFIGURED, Configured(wanted.request, answers.mapValues { (_, it) -> it.toBody() }))
    }

    private suspend fun announceAdditions(control: ControlLane) = announcing.withLock {
        if (openRequest != null) announce(streams.channels().filter { it.lane == SessionLanes.SENSORS }, control)
    }

    private suspend fun announce(channels: List<ChannelBody>, control: ControlLane) {
        for (channel in channels.filter { announced.add(it.id) }) {
            control.write(FrameKind.CHANNEL, channel)
            written += channel.id
        }
    }

    private suspend fun endChannelsBut(channels: List<ChannelBody>, control: ControlLane) {
        val ended = announced - channels.map { it.id }.toSet()
        ended.forEach { control.write(FrameKind.CHANNEL_END, ChannelEnd(it)) }
        announced -= ended
    }

    private fun checkRequest(start: Start) {
        if (start.request == openRequest) return
        throw ProtocolException(ErrorCode.UNEXPECTED, "expected START of request $openRequest, found ${start.request}")
    }

    private suspend fun reportStatus(control: ControlLane, drained: Deferred<Unit>) {
        while (withTimeoutOrNull(STATUS_INTERVAL) { drained.await() } == null) writeStatus(control, final = false)
        writeStatus(control, final = true)
    }

    /** Until all is [drained], and with it the events, which come first when both are there. */
    private suspend fun reportEvents(control: ControlLane, drained: Deferred<Unit>) {
        while (true) {
            val event = select {
                streams.events.onReceive { it }
                drained.onAwait { null }
            }
            control.write(FrameKind.EVENT, event ?: return)
        }
    }

    private suspend fun reportFailures(control: ControlLane) {
        for (failure in streams.failures) {
            val message = "stream ${failure.stream} ended: ${failure.reason}"
            control.write(FrameKind.ERROR, ErrorBody.of(ErrorCode.SOURCE, message, fatal = false))
            announcing.withLock { endChannelsBut(streams.channels(), control) }
        }
    }

    private suspend fun writeStatus(control: ControlLane, final: Boolean) {
        val uptimeSeconds = PROCESS_START.elapsedNow().inWholeMilliseconds / 1000.0
        control.write(
            FrameKind.STATUS,
            Status(final, uptimeSeconds, streams.counts(), hostClock.toBody(streams.timestampBases)),
        )
    }

    private suspend fun open(urgent: Boolean): Connection = handshake("a connection to $receiver", FIRST_LIMIT) {
        blockingIo {
            Connection.open(receiver, security, hostClock::rosNowNanos, urgent).also(connections::add)
        }
    }

    private companion object {
        /** Patience before WELCOME tells the receiver's. */
        val FIRST_LIMIT = 5.seconds
        val STATUS_INTERVAL = 1.seconds
        val IN_SESSION =
            setOf(
                FrameKind.CONFIGURE,
                FrameKind.START,
                FrameKind.LINK_TEST,
                FrameKind.ERROR,
                FrameKind.PING,
                FrameKind.PONG,
                FrameKind.BYE,
            )
        val PROCESS_START = TimeSource.Monotonic.markNow()
    }
}

/** Runs [block] on a thread that may block; after our BYE it does not matter how it ends. */
private fun CoroutineScope.part(control: ControlLane, block: suspend () -> Unit): Job = launch(Dispatchers.IO) {
    try {
        block()
    } catch (e: IOException) {
        if (!control.saidBye) throw e
    }
}

internal fun HostClock.toBody(bases: Map<String, String>): Status.Clock = status.let {
    Status.Clock(
        it.state.wireName,
        it.offsetNanos,
        it.uncertaintyNanos,
        it.roundTripNanos,
        it.skewPpm,
        it.steps,
        it.epoch,
        bases,
    )
}

private fun Answer.toBody(): Configured.StreamAnswer = when (this) {
    is Answer.Applied -> Configured.StreamAnswer("applied", values = values)
    is Answer.Adjusted -> Configured.StreamAnswer("adjusted", values, reason)
    is Answer.Refused -> Configured.StreamAnswer("refused", reason = reason)
}
