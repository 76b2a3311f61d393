package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.simulator.signal.samples
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.async
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.catch
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.flow

/**
 * A headset that delivers test signals for every sensor and mode of the stream table, in real time.
 *
 * Motion, gravity, magnetic field, gaze and hands follow one head trajectory in the world frame, chosen by [seed].
 * Cameras show a loop of a moving scene, at least a second long, that is rendered before the first sample. Each image
 * holds its capture number, in the format of [FrameNumber]. The number counts from 0 each time a stream is collected,
 * and includes lost captures.
 *
 * All sensors share one start time, soon after the first stream is collected. Capture times are that start plus whole
 * periods, so that sensors of equal rate capture at the same times. Samples are emitted in the collector's context,
 * after their capture time. A collector that is more than 250 ms late loses captures (`SOURCE_LATE`). A collector that
 * retains all buffers of a camera loses its next captures (`NO_BUFFER`).
 *
 * @param seed equal seeds give equal samples, relative to the start time.
 * @param clock must run at the speed of coroutine delays.
 * @param log receives a line when rendering of a camera starts and ends, on any thread; rendering can take seconds.
 */
public class TestSignalHeadset(seed: Long, override val clock: DeviceClock, log: (String) -> Unit = {}) : Headset {
    override val identity: Headset.Identity = Headset.Identity("test-signal-$seed", "Test signals, seed $seed")
    override val timeline: Headset.Timeline get() = Headset.Timeline.LIVE

    private val life = SupervisorJob()
    private val scope = CoroutineScope(life)
    private val frameCache = FrameCache(scope, log)
    private val trajectory = Trajectory(seed)
    private val signals = imuSignals(trajectory) + environmentSignals(trajectory) + trackingSignals(trajectory)

    // Rendering uses all cores, so no sensor starts until the frames of all streams started together are rendered
    private val startNanos = scope.async(start = CoroutineStart.LAZY) {
        delay(GATHERING_MILLIS)
        frameCache.awaitAll()
        clock.nowNanos() + HEAD_START_NANOS
    }

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = stream.answer(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        require(stream.modes.isNotEmpty() || stream.id in signals) {
            "expected a sensor's stream, found $stream, which is derived from other streams"
        }
        val samples = flow {
            val loop = if (stream.modes.isEmpty()) null else frameCache.of(stream, values)
            val start = startNanos.await()
            val signal = loop?.await()?.signal(checkNotNull(values.rateHz), trajectory) ?: signals.getValue(stream.id)
            emitAll(signal.samples(clock, start, life))
        }
        return samples.catch { if (life.isActive) throw it }
    }

    override fun close(): Unit = life.cancel()

    private companion object {
        /** The time in which the other streams of a configuration are started. */
        const val GATHERING_MILLIS = 50L

        /** The time in which all of them get ready for the first sample. */
        const val HEAD_START_NANOS = 50_000_000L
    }
}
