package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.simulator.signal.readings
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
 * A headset that has every sensor and mode of the stream table and delivers test signals from them, in real time.
 *
 * Motion, gravity, magnetic field, gaze and hands follow one head trajectory in the world frame, chosen by [seed].
 * Cameras show a loop of a moving scene, at least a second long, that is drawn before the first sample; the number of
 * the capture is written into each image as [FrameNumber] says. It counts from 0 each time a stream is collected, and
 * includes captures that were lost.
 *
 * The sensors share one schedule, which begins soon after the first stream is collected: capture instants are its
 * start plus whole periods, so that sensors of one rate capture together. Samples are emitted in the collector's
 * context, after their instant. A collector that is late by more than 50 ms and a period loses captures
 * (`SOURCE_LATE`); one that keeps all buffers of an image loses the next (`NO_BUFFER`).
 *
 * @param seed the same seed gives the same samples relative to the start of the schedule.
 * @param clock runs at the speed of coroutine delays.
 * @param log gets a line when the drawing of a camera's loop begins and ends, from any thread; large ones take seconds.
 */
public class TestSignalHeadset(seed: Long, override val clock: DeviceClock, log: (String) -> Unit = {}) : Headset {
    override val identity: Headset.Identity = Headset.Identity("test-signal-$seed", "Test signals, seed $seed")
    override val timeline: Headset.Timeline get() = Headset.Timeline.LIVE

    private val life = SupervisorJob()
    private val scope = CoroutineScope(life)
    private val films = Films(scope, log)
    private val trajectory = Trajectory(seed)
    private val signals = inertialUnits(trajectory) + surroundings(trajectory) + trackedPoses(trajectory)

    // Drawing takes all cores: no sensor runs until all streams that were started together have their images.
    private val startNanos = scope.async(start = CoroutineStart.LAZY) {
        delay(GATHERING_MILLIS)
        films.awaitAll()
        clock.nowNanos() + HEAD_START_NANOS
    }

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = stream.answer(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        require(stream.modes.isNotEmpty() || stream.id in signals) { "$stream is made of other streams" }
        val samples = flow {
            val film = if (stream.modes.isEmpty()) null else films.of(stream, values)
            val start = startNanos.await()
            val signal = film?.await()?.signal(checkNotNull(values.rateHz), trajectory) ?: signals.getValue(stream.id)
            emitAll(signal.readings(clock, start, life))
        }
        return samples.catch { if (life.isActive) throw it }
    }

    override fun close(): Unit = life.cancel()

    private companion object {
        /** In which the other streams of a configuration are started. */
        const val GATHERING_MILLIS = 50L

        /** In which all of them reach the first tick. */
        const val HEAD_START_NANOS = 50_000_000L
    }
}
