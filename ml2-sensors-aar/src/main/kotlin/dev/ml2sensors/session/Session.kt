package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.ChannelEnd
import dev.ml2sensors.wire.Configure
import dev.ml2sensors.wire.Configured
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Start
import dev.ml2sensors.wire.Status
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.launch
import kotlinx.coroutines.runInterruptible
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * One session from HELLO to its end, on the device's side; PROTOCOL.md, Connecting. Owns the session's connections; the
 * lanes and streams that use them outlive it.
 */
internal class Session(
    private val receiver: ReceiverAddress,
    private val deviceClock: DeviceClock,
    private val hostClock: HostClock,
    private val streams: StreamControl,
) {
    private val connections = mutableListOf<Connection>()
    private val announced = HashSet<Int>()
    private var openRequest: Int? = null

    /**
     * Runs the session until [stop] completes, then ends it in order: everything offered is sent, then the final STATUS,
     * then BYE.
     *
     * @param onWelcome is told the receiver's name.
     * @throws IOException when the session is refused or lost; nothing of it is left running.
     */
    suspend fun run(hello: Hello, stop: Deferred<String>, onWelcome: (String) -> Unit) {
        try {
            val connection = open(null)
            val control = ControlLane(connection)
            try {
                val welcome: Welcome = handshake("WELCOME") {
                    connection.write(FrameKind.HELLO, hello)
                    connection.expect(FrameKind.WELCOME)
                }
                check(welcome, hello)
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

    private fun check(welcome: Welcome, hello: Hello) {
        if (welcome.version !in hello.versions) {
            throw ProtocolException(ErrorCode.VERSION, "expected one of ${hello.versions}, found ${welcome.version}")
        }
        val missing = listOf(SessionLanes.TIME, SessionLanes.SENSORS) - welcome.tickets.keys
        if (missing.isNotEmpty()) throw ProtocolException(ErrorCode.MALFORMED, "WELCOME without tickets for $missing")
    }

    private suspend fun converse(control: ControlLane, welcome: Welcome, stop: Deferred<String>) = coroutineScope {
        val lanes = SessionLanes(welcome, ::open, streams::lane)
        hostClock.linkUp()
        val timeLane = TimeLane(lanes.joinTime(), deviceClock, hostClock)
        lanes.join(SessionLanes.SENSORS)
        launch(Dispatchers.IO) { timeLane.run() }
        launch { control.keepAlive(welcome.timeouts) }
        launch { reportFailures(control) }
        val statusing = launch { reportStatus(control) }
        val reading = launch {
            while (true) handle(control.read() ?: break, control, lanes, this@coroutineScope)
        }
        val reason = stop.await()
        streams.stopSources()
        lanes.finish(LINGER)
        statusing.cancel()
        writeStatus(control, final = true)
        control.finish(reason)
        withTimeoutOrNull(LINGER) { reading.join() }
        coroutineContext.cancelChildren()
    }

    private suspend fun handle(frame: Frame, control: ControlLane, lanes: SessionLanes, scope: CoroutineScope) {
        when (frame.kind) {
            FrameKind.CONFIGURE -> configure(ControlJson.decode(frame.body), control, lanes)
            FrameKind.START -> {
                checkRequest(ControlJson.decode(frame.body))
                lanes.startSending(scope)
                scope.launch { streams.start() }
            }
            FrameKind.PING -> control.write(FrameKind.PONG)
            FrameKind.PONG, FrameKind.ERROR -> Unit
            FrameKind.BYE -> throw IOException("the receiver left: ${ControlJson.decode<Bye>(frame.body).reason}")
            else -> throw ProtocolException(ErrorCode.UNEXPECTED, "${frame.kind} is not for the device's control lane")
        }
    }

    private suspend fun configure(wanted: Configure, control: ControlLane, lanes: SessionLanes) {
        val answers = streams.configure(wanted.streams)
        val channels = streams.channels()
        channels.forEach { lanes.join(it.lane) }
        (announced - channels.map { it.id }.toSet()).forEach { control.write(FrameKind.CHANNEL_END, ChannelEnd(it)) }
        channels.filter { it.id !in announced }.forEach { control.write(FrameKind.CHANNEL, it) }
        announced.clear()
        channels.mapTo(announced) { it.id }
        control.write(FrameKind.CONFIGURED, Configured(wanted.request, answers.mapValues { (_, it) -> it.toBody() }))
        openRequest = wanted.request
    }

    private fun checkRequest(start: Start) {
        if (start.request == openRequest) return
        throw ProtocolException(ErrorCode.UNEXPECTED, "expected START of request $openRequest, found ${start.request}")
    }

    private suspend fun reportStatus(control: ControlLane) {
        while (true) {
            delay(STATUS_INTERVAL)
            writeStatus(control, final = false)
        }
    }

    private suspend fun reportFailures(control: ControlLane) {
        for (failure in streams.failures) {
            val message = "stream ${failure.stream} ended: ${failure.reason}"
            control.write(FrameKind.ERROR, ErrorBody(ErrorCode.SOURCE.wireName, message, fatal = false))
        }
    }

    private suspend fun writeStatus(control: ControlLane, final: Boolean) {
        val uptimeSeconds = PROCESS_START.elapsedNow().inWholeMilliseconds / 1000.0
        control.write(FrameKind.STATUS, Status(final, uptimeSeconds, streams.counts(), clockStatus()))
    }

    private fun clockStatus(): Status.Clock {
        val (state, estimate) = hostClock.status
        return Status.Clock(
            state.wireName,
            estimate?.offsetNanos ?: 0,
            estimate?.uncertaintyNanos ?: 0,
            estimate?.roundTripNanos ?: 0,
        )
    }

    private suspend fun open(sendBufferBytes: Int?): Connection =
        runInterruptible(Dispatchers.IO) { Connection.open(receiver, hostClock::rosNowNanos, sendBufferBytes) }
            .also(connections::add)

    private companion object {
        val LINGER = 2.seconds
        val STATUS_INTERVAL = 1.seconds
        val PROCESS_START = TimeSource.Monotonic.markNow()
    }
}

/** Runs blocking [exchange], which must not take longer than PROTOCOL.md allows a handshake. */
internal suspend fun <T> handshake(awaited: String, exchange: () -> T): T =
    withTimeoutOrNull(HANDSHAKE_LIMIT) { Result.success(runInterruptible(Dispatchers.IO, exchange)) }?.getOrThrow()
        ?: throw ProtocolException(ErrorCode.TIMEOUT, "expected $awaited within $HANDSHAKE_LIMIT")

private val HANDSHAKE_LIMIT = 5.seconds

private fun Answer.toBody(): Configured.StreamAnswer = when (this) {
    is Answer.Applied -> Configured.StreamAnswer("applied", values = values)
    is Answer.Adjusted -> Configured.StreamAnswer("adjusted", values, reason)
    is Answer.Refused -> Configured.StreamAnswer("refused", reason = reason)
}
