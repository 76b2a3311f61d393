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
import kotlinx.coroutines.cancelChildren
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.combine
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.launch
import kotlin.time.Duration

/**
 * Streams [headset] over [link] and says what happens, until a recording is over, [duration] has passed since the
 * first sample, or [stop] is completed. At the first sample it launches [onBegun]. A receiver that lets the app
 * publish gets [AppUptime], too.
 *
 * @return whether no sensor stands still at the end.
 */
internal suspend fun stream(
    headset: Headset,
    link: Link,
    duration: Duration?,
    stop: CompletableDeferred<String>,
    say: (String) -> Unit,
    onBegun: suspend () -> Unit,
): Boolean = coroutineScope {
    val hasBegun = CompletableDeferred<Unit>()
    val streamer = Ml2Streamer(ObservedHeadset(headset, hasBegun), link.receiver, link.security)
    val uptime = AppUptime(streamer, headset.clock)
    val narration = launch { streamer.narrate(link.receiver, say) }
    launch { stop.complete(streamer.state.filterIsInstance<StreamerState.Ended>().first().reason) }
    launch {
        hasBegun.await()
        onBegun()
    }
    if (duration != null) {
        launch {
            hasBegun.await()
            delay(duration)
            stop.complete("$duration are over")
        }
    }
    streamer.start()
    launch { uptime.run() }
    val reason = stop.await()
    streamer.stop(reason)
    narration.join()
    say("ended: $reason")
    coroutineContext.cancelChildren()
    streamer.streams.value.values.none { it is StreamState.Waiting || it is StreamState.Failed }
}

/** The [headset], which completes [hasBegun] with the first sample of any stream. */
private class ObservedHeadset(private val headset: Headset, private val hasBegun: CompletableDeferred<Unit>) :
    Headset by headset {
    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        headset.samples(stream, values).onEach { hasBegun.complete(Unit) }
}

/** Says where the streamer is and what became of each stream, whenever that changes, until it has ended. */
private suspend fun Ml2Streamer.narrate(receiver: Receiver, say: (String) -> Unit) {
    var lastState: StreamerState? = null
    var lastStreams = emptyMap<String, StreamState>()
    combine(state, streams, ::Pair).first { (state, streams) ->
        if (state != lastState) state.inWords(receiver)?.let(say)
        for (id in lastStreams.keys - streams.keys) say("  $id: ended")
        for ((id, stream) in streams) if (stream != lastStreams[id]) say("  $id: ${stream.inWords()}")
        lastState = state
        lastStreams = streams
        state is StreamerState.Ended
    }
}

private fun StreamerState.inWords(receiver: Receiver): String? = when (this) {
    is StreamerState.Connecting -> "connecting to $receiver" + reason?.let { ": $it" }.orEmpty()

    is StreamerState.Connected ->
        if (receiver is ReceiverAddress) "connected to $receiverName at $receiver" else "connected to $receiverName"

    is StreamerState.Ended -> null
}

private fun StreamState.inWords(): String = when (this) {
    is StreamState.Accepted -> values.inWords() + adjusted?.let { " (adjusted: $it)" }.orEmpty()
    is StreamState.Waiting -> "waiting: $reason"
    is StreamState.Refused -> "refused: $reason"
    is StreamState.Failed -> "failed: $reason"
}

private fun StreamValues.inWords(): String =
    if (width == null) "accepted" else "accepted, ${width}x$height@$rateHz $format"
