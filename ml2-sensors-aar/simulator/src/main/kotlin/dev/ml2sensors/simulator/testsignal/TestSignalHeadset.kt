package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.flow

public class TestSignalHeadset(
    seed: Long,
    override val clock: DeviceClock,
    log: (String) -> Unit = {},
) : Headset {
    override val identity: Headset.Identity = Headset.Identity("test-signal-$seed", "Test signals")
    override val timeline: Headset.Timeline get() = Headset.Timeline.LIVE

    private val life = SupervisorJob()
    private val films = Films(CoroutineScope(life), log)
    private val trajectory = Trajectory(seed)
    private val signals = inertialUnits(trajectory) + surroundings(trajectory) + trackedPoses(trajectory)
    private val startNanos by lazy { clock.nowNanos() + START_DELAY_NANOS }

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = stream.answer(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
        val signal = if (stream.modes.isEmpty()) signals.getValue(stream.id) else camera(stream, values)
        films.awaitAll()
        emitAll(signal.readings(clock, startNanos, life))
    }

    private suspend fun camera(stream: StreamSpec, values: StreamValues): Signal {
        val film = films.of(stream, values).await()
        return Signal(checkNotNull(values.rateHz)) { film.sample(it, trajectory.at(it.seconds).pose) }
    }

    override fun close(): Unit = life.cancel()

    private companion object {
        const val START_DELAY_NANOS = 100_000_000L
    }
}
