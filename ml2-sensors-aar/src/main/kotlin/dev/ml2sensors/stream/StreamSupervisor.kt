package dev.ml2sensors.stream

import dev.ml2sensors.source.RefusedException
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.delay
import kotlinx.coroutines.ensureActive
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.transform
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/**
 * Keeps one live stream running: restarts it after a pause when it fails or ends. Pauses grow to 5 s, and are short
 * again once a run has delivered for that long. Used by one coroutine.
 *
 * @param onState receives [StreamState.Waiting] or [StreamState.Refused] when the stream stops and when the reason
 * changes, and null when a sample was processed again.
 */
internal class StreamSupervisor(
    private val time: TimeSource = TimeSource.Monotonic,
    private val onState: suspend (StreamState?) -> Unit,
) {
    private val backOff = BackOff(time, SHORTEST, LONGEST)
    private var outage: StreamState? = null
    private var deliversSince: TimeMark? = null
    private var isSettled = false

    /** Collects the samples of [open] with [collect], again and again until cancelled. */
    suspend fun run(open: () -> Flow<Sample>, collect: suspend (Flow<Sample>) -> Unit): Nothing {
        while (true) {
            deliversSince = null
            isSettled = false
            backOff.begin()
            val cause = try {
                collect(
                    open().transform {
                        emit(it)
                        delivered()
                    },
                )
                SourceException("the source has ended")
            } catch (e: Throwable) {
                currentCoroutineContext().ensureActive() // else it is this stream that was stopped
                e
            }
            report(cause.toState())
            delay(backOff.pause())
        }
    }

    private suspend fun delivered() {
        if (isSettled) return
        val since = deliversSince ?: time.markNow().also { deliversSince = it }
        report(null)
        if (since.elapsedNow() < LONGEST) return
        isSettled = true
        backOff.succeeded()
    }

    private suspend fun report(now: StreamState?) {
        if (now == outage) return
        onState(now)
        outage = now
    }

    private companion object {
        val SHORTEST = 200.milliseconds
        val LONGEST = 5.seconds
    }
}

private fun Throwable.toState(): StreamState = when (this) {
    is RefusedException -> answer.toState()
    is SourceException -> StreamState.Waiting(words(), permission)
    else -> StreamState.Waiting(words())
}

/** Returns the reason for a user. */
internal fun Throwable.words(): String {
    val text = message
    return if (this is SourceException && text != null) text else "${javaClass.simpleName}: $text"
}
