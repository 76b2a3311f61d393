package dev.ml2sensors.simulator

import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamState
import dev.ml2sensors.stream.StreamerState
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.combine
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.joinAll
import kotlinx.coroutines.launch
import kotlin.time.Duration

/**
 * Streams [headset] over [connection] and logs what happens, until a recording ends, [duration] has passed since the first
 * sample, or [stop] is completed. Calls [onFirstSample] at the first sample. Publishes [AppUptime] if the receiver
 * takes custom topics, and what [app] says.
 *
 * @return false if a stream is waiting or has failed at the end.
 */
internal suspend fun stream(
    headset: Headset,
    connection: ConnectionSettings,
    duration: Duration?,
    stop: CompletableDeferred<String>,
    app: AppParts,
    log: (String) -> Unit,
    onFirstSample: suspend () -> Unit,
): Boolean = coroutineScope {
    val firstSample = CompletableDeferred<Unit>()
    val streamer = Ml2Streamer(ObservedHeadset(headset, firstSample), connection.receiver, connection.security)
    val uptime = AppUptime(streamer, headset.clock)
    val printing = app.printed.map { it.printer(streamer, log) }.map { launch { it() } }
    val lasting = app.offered.map { it.logger(streamer, log) } + callsAsRead(app.called, streamer, log)
    val publishing = app.published.map { it.publishing(streamer, headset.clock, log) }
    val logging = launch { streamer.logChanges(connection.receiver, log) }
    launch { stop.complete(streamer.state.filterIsInstance<StreamerState.Ended>().first().reason) }
    launch {
        firstSample.await()
        onFirstSample()
    }
    if (duration != null) {
        launch {
            firstSample.await()
            delay(duration)
            stop.complete("the duration of $duration is over")
        }
    }
    streamer.start()
    launch { uptime.run() }
    lasting.forEach { launch { it() } }
    publishing.forEach { launch(Dispatchers.Default) { it() } }
    val reason = stop.await()
    streamer.stop(reason)
    (printing + logging).joinAll()
    log("ended: $reason")
    coroutineContext.cancelChildren()
    streamer.streams.value.values.none { it is StreamState.Waiting || it is StreamState.Failed }
}

/** The parts of the app that use ROS, by the options of the command. */
internal class AppParts(
    val printed: List<Printed>,
    val called: List<CalledService>,
    val offered: List<OfferedService>,
    val published: List<PublishedTopic>,
)

/** Passes on the samples of [headset], and completes [firstSample] with the first one of any stream. */
private class ObservedHeadset(private val headset: Headset, private val firstSample: CompletableDeferred<Unit>) :
    Headset by headset {
    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        headset.samples(stream, values).onEach { firstSample.complete(Unit) }
}

/** Logs each change of the connection and of each stream, until the streamer ends. */
private suspend fun Ml2Streamer.logChanges(receiver: Receiver, log: (String) -> Unit) {
    var lastState: StreamerState? = null
    var lastStreams = emptyMap<String, StreamState>()
    combine(state, streams, ::Pair).first { (state, streams) ->
        if (state != lastState) state.describe(receiver)?.let(log)
        for (id in lastStreams.keys - streams.keys) log("  $id: ended")
        for ((id, stream) in streams) if (stream != lastStreams[id]) log("  $id: ${stream.describe()}")
        lastState = state
        lastStreams = streams
        state is StreamerState.Ended
    }
}

private fun StreamerState.describe(receiver: Receiver): String? = when (this) {
    is StreamerState.Connecting -> "connecting to $receiver" + reason?.let { ": $it" }.orEmpty()

    is StreamerState.Connected ->
        if (receiver is ReceiverAddress) "connected to $receiverName at $receiver" else "connected to $receiverName"

    is StreamerState.Ended -> null
}

private fun StreamState.describe(): String = when (this) {
    is StreamState.Running -> values.describe() + adjusted?.let { " (adjusted: $it)" }.orEmpty()
    is StreamState.Waiting -> "waiting: $reason"
    is StreamState.Refused -> "refused: $reason"
    is StreamState.Failed -> "failed: $reason"
}

private fun StreamValues.describe(): String =
    if (width == null) "running" else "running, ${width}x$height@$rateHz $format"
