package dev.ml2sensors.simulator.signal

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow

/** Simulates a [backend] of the platform: delivers [signals] at whole periods of the [clock]. */
internal class SignalSource(
    override val backend: String,
    private val clock: DeviceClock,
    private val signals: Map<StreamSpec, Signal>,
) : SensorSource {
    private val life = Job()

    override val streams: Set<StreamSpec> get() = signals.keys

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = Answer.Applied(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        signals.getValue(stream).samples(clock, startNanos = 0, life)

    /** Ends all flows. */
    override fun close(): Unit = life.cancel()
}
