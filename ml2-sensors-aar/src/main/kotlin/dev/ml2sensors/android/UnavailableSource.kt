package dev.ml2sensors.android

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow

/** Refuses all streams of a [backend] that this device does not have, for a [reason]. */
internal class UnavailableSource(
    override val backend: String,
    override val streams: Set<StreamSpec>,
    private val reason: String,
) : SensorSource {
    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = Answer.Refused(reason)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        flow { throw SourceException(reason) }

    override fun close(): Unit = Unit
}
