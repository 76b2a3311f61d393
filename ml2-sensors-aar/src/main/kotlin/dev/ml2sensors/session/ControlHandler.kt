package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.source.Answer
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Bye
import dev.ml2sensors.wire.Configure
import dev.ml2sensors.wire.Configured
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ErrorBody
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.LinkTestBody
import dev.ml2sensors.wire.Start
import dev.ml2sensors.wire.Status
import dev.ml2sensors.wire.printable
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Job
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.launch
import kotlinx.coroutines.selects.select
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * Handles the control connection between WELCOME and BYE: requests with their answers, and reports.
 *
 * @param stop completes when the session is to end; requests that were not begun by then are not answered.
 */
internal class ControlHandler(
    private val control: ControlLane,
    private val lanes: SessionLanes,
    private val openings: OpeningLanes?,
    private val streams: StreamControl,
    private val hostClock: HostClock,
    private val stop: Deferred<*>,
) {
    private val handling = Mutex()
    private val allowed = if (openings == null) IN_SESSION else IN_SESSION + OpeningLanes.ON_CONTROL
    private val announcer = ChannelAnnouncer(streams, control)
    private val reports = streams.reports

    /**
     * Reads frames until the receiver closes the connection after our BYE. Requests are handled in order by another
     * coroutine, after [joining] has joined the first lanes: a slow request delays no PONG and does not count as
     * silence.
     */
    suspend fun handleFrames(joining: Job): Unit = coroutineScope {
        val requests = Channel<Frame>(MOST_REQUESTS)
        launch {
            joining.join()
            for (request in requests) handling.withLock { if (!stop.isCompleted) handle(request) }
        }
        while (true) {
            val frame = control.read(allowed) ?: break
            when (frame.kind) {
                FrameKind.PING -> control.write(FrameKind.PONG)

                FrameKind.PONG -> Unit

                in OpeningLanes.ON_CONTROL -> openings?.received(frame)

                FrameKind.BYE -> throw IOException(
                    "the receiver left: ${printable(ControlJson.decode<Bye>(frame.body).reason)}",
                )

                else -> requests.send(frame)
            }
        }
        requests.close()
    }

    /** Waits after [stop] for the request that is being handled: then lanes and streams belong to the caller alone. */
    suspend fun awaitLastRequest(): Unit = handling.withLock {}

    private suspend fun handle(frame: Frame) {
        when (frame.kind) {
            FrameKind.CONFIGURE -> configure(ControlJson.decode(frame.body))

            FrameKind.START -> {
                val known = announcer.knownAt(ControlJson.decode<Start>(frame.body))
                lanes.startSending()
                streams.start(known)
            }

            FrameKind.LINK_TEST -> lanes.linkTest.begin(ControlJson.decode<LinkTestBody>(frame.body).bytes)

            FrameKind.ERROR -> {
                val error = ControlJson.decode<ErrorBody>(frame.body)
                error.channel?.let { streams.refuse(it, printable(error.message)) }
            }

            else -> error("${frame.kind} is no request")
        }
    }

    private suspend fun configure(wanted: Configure) {
        lanes.pacing.limit(wanted.link?.mostMbitPerSecond?.let { it * BYTES_PER_MBIT })
        val answers = streams.configure(wanted.streams, wanted.framePrefix, adapts = wanted.link?.adapts == true)
        lanes.join(streams.channels().map { it.lane }.toSet())
        announcer.announceConfigured(wanted.request)
        control.write(FrameKind.CONFIGURED, Configured(wanted.request, answers.mapValues { (_, it) -> it.toBody() }))
    }

    /** Announces channels that the app adds. */
    suspend fun reportAdditions() {
        for (addition in streams.additions) {
            handling.withLock {
                if (stop.isCompleted) return
                val channels = streams.channels().filter { it.stream == StreamTable.custom.id }
                lanes.join(channels.map { it.lane }.toSet())
                announcer.announceAdditions(channels)
            }
        }
    }

    suspend fun reportFailures() {
        for (failure in reports.failures) {
            val message = "stream ${failure.stream} ended${failure.ago()}: ${failure.reason}"
            control.write(FrameKind.ERROR, ErrorBody.of(ErrorCode.SOURCE, message, fatal = false))
            announcer.endRemoved()
        }
    }

    /** Sends events until all data is [drained]; pending events are sent first. */
    suspend fun reportEvents(drained: Deferred<Unit>): Unit =
        reports.events.sendUntil(drained) { control.write(FrameKind.EVENT, it) }

    /** Sends STATUS once a second and when the state of a stream changes; the final one when all data is [drained]. */
    suspend fun reportStatus(drained: Deferred<Unit>) {
        while (!drained.isCompleted) {
            withTimeoutOrNull(STATUS_INTERVAL) {
                select {
                    drained.onAwait { }
                    reports.stateChanges.onReceive { }
                }
            }
            if (!drained.isCompleted) writeStatus(final = false)
        }
        writeStatus(final = true)
    }

    private suspend fun writeStatus(final: Boolean) {
        val uptimeSeconds = PROCESS_START.elapsedNow().inWholeMilliseconds / 1000.0
        control.write(
            FrameKind.STATUS,
            Status(
                final,
                uptimeSeconds,
                reports.counts(),
                hostClock.toBody(reports.timestampBases),
                reports.thermal,
                reports.streamStates,
                openings?.counts().orEmpty(),
                openings?.calls().orEmpty(),
                reports.conditions,
            ),
        )
    }

    private companion object {
        val STATUS_INTERVAL = 1.seconds
        const val BYTES_PER_MBIT = 1e6 / 8

        /** If a receiver sends more requests before an answer, reading pauses. */
        const val MOST_REQUESTS = 64
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
