package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Welcome
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Job
import kotlinx.coroutines.async
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.launch
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.net.InetAddress
import java.util.concurrent.ConcurrentLinkedQueue
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/**
 * One session from HELLO to its end, on the device's side; PROTOCOL.md, Connecting. Owns the session's connections;
 * lanes and streams outlive it.
 *
 * @param app the openings of its app; null if HELLO does not say `ros`.
 */
internal class Session(
    private val receiver: ReceiverAddress,
    private val security: TransportSecurity,
    private val deviceClock: DeviceClock,
    private val hostClock: HostClock,
    private val streams: StreamControl,
    private val resolve: (String) -> List<InetAddress> = ::addressesOf,
    private val app: AppOpenings? = null,
) {
    private val connections = ConcurrentLinkedQueue<Connection>()

    /**
     * Runs the session until [stop] completes, then ends it in order: all queued data is sent, then the final STATUS,
     * then BYE.
     *
     * @param onWelcome receives the receiver's name.
     * @throws IOException when the session is refused or lost; nothing of it is left running.
     */
    suspend fun run(hello: Hello, stop: Deferred<String>, onWelcome: (String) -> Unit) {
        try {
            val control = ControlLane(unlessStopped(stop) { open(urgent = true) } ?: return)
            try {
                val welcome = unlessStopped(stop) { exchangeHello(control, hello) } ?: return
                streams.beginSession(welcome.received, servesApps = app != null && welcome.ros != null)
                onWelcome(welcome.name)
                runParts(control, welcome, stop)
            } catch (e: ProtocolException) {
                if (!e.isPeers) control.sendError(e)
                throw e
            }
        } finally {
            hostClock.endSession()
            connections.forEach(Connection::close)
        }
    }

    private suspend fun exchangeHello(control: ControlLane, hello: Hello): Welcome {
        control.write(FrameKind.HELLO, hello)
        val frame = handshake("WELCOME", FIRST_LIMIT) { control.read(setOf(FrameKind.WELCOME)) }
        val welcome = ControlJson.decode<Welcome>(frame.body)
        if (welcome.version !in hello.versions) {
            throw ProtocolException(ErrorCode.VERSION, "expected one of ${hello.versions}, found ${welcome.version}")
        }
        val hasOpenings = app != null && welcome.ros != null
        welcome.violation(hasOpenings)?.let { throw ProtocolException(ErrorCode.MALFORMED, "invalid WELCOME: $it") }
        if (hasOpenings) control.allowOpenings()
        return welcome
    }

    private suspend fun runParts(control: ControlLane, welcome: Welcome, stop: Deferred<String>) = coroutineScope {
        val opened = app?.takeIf { welcome.ros != null }
        val lanes = SessionLanes(welcome, opened != null, ::open, streams::lane) { launchPart(control, it) }
        val openings = opened?.let { app ->
            OpeningLanes(control, app, lanes::connectToOpenings) { launchPart(control, it) }
        }
        val handler = ControlHandler(control, lanes, openings, streams, hostClock, stop)
        launchPart(control) { control.keepAlive(welcome.timeouts) }
        val joining = async { lanes.joinTime().also { lanes.join(setOf(StreamTable.sensorsLane.name)) } }
        val listening = launchPart(control) { handler.handleFrames(joining) }
        val timeLane = TimeLane(joining.await(), deviceClock, hostClock, lanes.pacing)
        val comparing = launchPart(control) { timeLane.run() }
        launchPart(control) { app?.serve(openings) }
        launchPart(control) { streams.adaptTo(lanes.pacing) }
        launchPart(control) { handler.reportFailures() }
        launchPart(control) { handler.reportAdditions() }
        val drained = CompletableDeferred<Unit>()
        val events = launchPart(control) { handler.reportEvents(drained) }
        val status = launchPart(control) { handler.reportStatus(drained) }
        val reason = stop.await()
        handler.awaitLastRequest()
        streams.stopSources()
        lanes.finish(streams.drainLimit)
        openings?.finish(streams.drainLimit)
        drained.complete(Unit)
        events.join()
        status.join()
        timeLane.finish()
        withTimeoutOrNull(TIME_LIMIT) { comparing.join() }
        control.finish(reason)
        withTimeoutOrNull(ControlLane.CLOSING_LIMIT) { listening.join() }
        coroutineContext.cancelChildren()
    }

    private suspend fun open(urgent: Boolean, pacing: ImagePacing? = null): Connection =
        handshake("a connection to $receiver", FIRST_LIMIT) {
            blockingIo {
                Connection.open(receiver, security, hostClock::rosNowNanos, urgent, pacing, ::addresses)
                    .also(connections::add)
            }
        }

    /** Resolves once for all lanes: to the address that answered the control connection. */
    private fun addresses(host: String) = connections.peek()?.let { listOf(it.address) } ?: resolve(host)

    private companion object {
        /** The time limit until WELCOME, which has the receiver's own limits. */
        val FIRST_LIMIT = 5.seconds

        /** More than a request, its reply and the pause before the next one take on a link that does not stall. */
        val TIME_LIMIT = 200.milliseconds
    }
}

/** Runs [block] on a thread that may block. After our BYE its I/O errors are ignored. */
private fun CoroutineScope.launchPart(control: ControlLane, block: suspend () -> Unit): Job = launch(blockingThreads) {
    try {
        block()
    } catch (e: IOException) {
        if (!control.byeWritten) throw e
    }
}
