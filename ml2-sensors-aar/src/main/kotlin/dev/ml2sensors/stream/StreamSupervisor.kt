package dev.ml2sensors.stream

import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.RefusedException
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.delay
import kotlinx.coroutines.ensureActive
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.transform
import kotlinx.coroutines.launch
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/**
 * Keeps one live stream running: restarts it after a pause when it fails, ends or falls silent. Pauses grow to 5 s, and
 * are short again once a run has delivered for that long. Used by one coroutine.
 *
 * @param longestPause the longest normal pause between two samples; the first may take [OPENING] longer. Null if the
 * stream may be silent for any time.
 * @param isHeld returns true while the headset holds the stream, which it tells by itself.
 * @param sleepReason returns [Headset.sleepReason]; meanwhile a silent stream waits and is not opened again.
 * @param isFuture returns true for a capture time so far ahead of the headset's clock that no message is made of it.
 * @param outage the state of the stream before, if it had stopped.
 * @param onState receives [StreamState.Waiting] or [StreamState.Refused] when the stream stops and when the reason
 * changes, and null when a sample was processed again.
 */
internal class StreamSupervisor(
    private val longestPause: Duration?,
    private val isHeld: () -> Boolean = { false },
    private val sleepReason: () -> String? = { null },
    private val time: TimeSource = TimeSource.Monotonic,
    private val isFuture: (captureNanos: Long) -> Boolean = { false },
    outage: StreamState? = null,
    private val onState: suspend (StreamState?) -> Unit,
) {
    private val backOff = BackOff(time, SHORTEST, LONGEST)
    private val reporting = Mutex()
    private var deliversSince: TimeMark? = null
    private var uselessSince: TimeMark? = null
    private var isSettled = false

    // Written by the collector or the watchdog, read by both
    @Volatile
    private var outage: StreamState? = outage

    @Volatile
    private var alive: TimeMark = time.markNow()

    /** Collects the samples of [open] with [collect], again and again until cancelled. */
    suspend fun run(open: () -> Flow<Sample>, collect: suspend (Flow<Sample>) -> Unit): Nothing {
        while (true) {
            deliversSince = null
            uselessSince = null
            isSettled = false
            backOff.begin()
            val cause = try {
                watched {
                    collect(
                        open().transform {
                            emit(it)
                            delivered(it)
                        },
                    )
                }
                SourceException("the source has ended")
            } catch (e: Throwable) {
                currentCoroutineContext().ensureActive() // else it is this stream that was stopped
                e
            }
            report(cause.toState())
            delay(backOff.pause())
        }
    }

    /**
     * Runs [collect], and fails when no sample comes for longer than [longestPause], which begins anew after a
     * standstill of this process.
     */
    private suspend fun watched(collect: suspend () -> Unit) {
        val pause = longestPause ?: return collect()
        alive = time.markNow() + OPENING
        coroutineScope {
            val watchdog = launch {
                while (true) {
                    val left = pause - alive.elapsedNow()
                    if (left > Duration.ZERO) {
                        val end = time.markNow() + left
                        delay(left)
                        // This process stood still, and the source has not been heard since
                        if (end.elapsedNow() > LATE) alive = time.markNow()
                    } else if (isHeld()) {
                        alive = time.markNow()
                    } else {
                        report(StreamState.Waiting(sleepReason() ?: failSilent(pause)))
                        alive = time.markNow()
                    }
                }
            }
            collect()
            watchdog.cancel()
        }
    }

    private suspend fun failSilent(pause: Duration): Nothing {
        val silence = SourceException("no capture for ${pause.inWholeSeconds} s")
        report(silence.toState()) // Before the source is closed, which takes long if it hangs
        throw silence
    }

    private suspend fun delivered(sample: Sample) {
        if (sample is LostSamples) return
        alive = time.markNow()
        if (sample is PoseSample && sample.pose == null) return useless(UNTRACKED)
        if (isFuture(sample.captureNanos)) return useless(FUTURE)
        uselessSince = null
        if (isSettled && outage == null) return
        val since = deliversSince ?: time.markNow().also { deliversSince = it }
        report(null)
        if (since.elapsedNow() < LONGEST) return
        isSettled = true
        backOff.succeeded()
    }

    /** Reports that a source that is alive delivers nothing of which a message is made, once that lasts. */
    private suspend fun useless(reason: String) {
        val since = uselessSince ?: time.markNow().also { uselessSince = it }
        if (longestPause != null && since.elapsedNow() >= longestPause) report(StreamState.Waiting(reason))
    }

    private suspend fun report(now: StreamState?): Unit = reporting.withLock {
        if (now == outage) return
        onState(now)
        outage = now
    }

    companion object {
        /** Returns a supervisor of [stream] with the pause of its row and the holds of [headset]. */
        fun of(
            stream: StreamSpec,
            headset: Headset,
            isFuture: (captureNanos: Long) -> Boolean = { false },
            outage: StreamState? = null,
            onState: suspend (StreamState?) -> Unit,
        ): StreamSupervisor = StreamSupervisor(
            stream.longestPauseSeconds?.seconds,
            isHeld = { stream.id in headset.holds },
            sleepReason = { headset.sleepReason },
            isFuture = isFuture,
            outage = outage,
            onState = onState,
        )

        private val SHORTEST = 200.milliseconds
        private val LONGEST = 5.seconds

        /** A busy headset ends a wait so late. */
        private val LATE = 500.milliseconds

        /** A camera of the platform may take seconds to open. */
        private val OPENING = 6.seconds
        private const val FUTURE = "its capture times are more than a second ahead of the headset's clock"
        private const val UNTRACKED = "tracking is lost: the headset delivers no pose"
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
