package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.DiagnosticArray
import dev.ml2sensors.message.DiagnosticStatus
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.KeyValue
import dev.ml2sensors.message.Time
import dev.ml2sensors.source.Condition
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.MapSample
import dev.ml2sensors.source.MapState
import dev.ml2sensors.source.MapState.Companion.CONFIDENCES
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import kotlinx.coroutines.flow.Flow

/**
 * Publishes how the headset is localized: its map as parent of the world through [tree], and the state in words on
 * [channel] when it changes, and once a second. Reports when the map comes and goes, since a transform that is not
 * sent any more stays in the buffers of its readers.
 */
internal class MapPipeline(
    private val values: StreamValues,
    private val channel: TopicChannel,
    private val stamps: StampMap,
    private val tree: TransformTree,
    private val frameIds: FrameIds,
    private val conditions: Conditions,
    private val report: (Event) -> Unit,
) {
    private var last: Condition? = null
    private var lastCaptureNanos = 0L

    /** Runs until [samples] end or fail. */
    suspend fun run(samples: Flow<Sample>) {
        try {
            samples.collect { sample ->
                when (sample) {
                    is MapSample -> add(sample)
                    is LostSamples -> channel.counters.countLost(sample.count, sample.reason)
                    else -> error("the map delivered $sample")
                }
            }
        } finally {
            conditions.set(Conditions.MAP, null)
            if (last?.isGood == true) report(Event(Event.MAP_LOST, "the map is not followed any more"))
        }
    }

    private suspend fun add(sample: MapSample) {
        tree.map(sample)
        val condition = condition(sample)
        conditions.set(Conditions.MAP, condition)
        val before = last
        if (before == condition && sample.captureNanos - lastCaptureNanos < REPEATED_AFTER_NANOS) return
        val stampNanos = stamps.stampNanos(sample.captureNanos)
            ?: return channel.counters.countLost(1, stamps.lossReason(sample.captureNanos))
        last = condition
        lastCaptureNanos = sample.captureNanos
        val header = Header(Time.ofNanos(stampNanos), frameIds.of(StreamTable.map))
        val message = DiagnosticArray(header, listOf(condition.toMessage()))
        channel.publish(DiagnosticArray.serializer(), message, stampNanos)
        if (condition.isGood != (before?.isGood == true)) {
            val name = if (condition.isGood) Event.MAP_LOCALIZED else Event.MAP_LOST
            report(Event(name, "map: ${condition.message}"))
        }
    }

    private fun condition(sample: MapSample): Condition {
        val state = sample.state
        val isLocalized = sample.origin != null
        return Condition(
            isLocalized,
            if (isLocalized) "localized in ${state.name}" else "no transform: ${reason(state)}",
            mapOf(
                "localization" to state.localization,
                "confidence" to state.confidence,
                "errors" to state.errors.joinToString(" "),
                "name" to state.name,
                "uuid" to state.uuid,
                "map_type" to state.type,
            ),
        )
    }

    private fun Condition.toMessage() = DiagnosticStatus(
        if (isGood) DiagnosticStatus.OK else DiagnosticStatus.WARN,
        Conditions.MAP,
        message,
        hardwareId = "",
        values.map { (key, value) -> KeyValue(key, value) },
    )

    /** Returns why a sample has no origin. */
    private fun reason(state: MapState): String {
        val wanted = values.localize.orEmpty()
        return when {
            state.localization == "unknown" -> "the headset has not said yet where it is localized"

            state.localization != "localized" -> "localization is ${state.localization}"

            wanted.isNotEmpty() && wanted != state.name && !wanted.equals(state.uuid, ignoreCase = true) ->
                "localized in ${state.name}, asked for $wanted"

            CONFIDENCES.indexOf(state.confidence) < CONFIDENCES.indexOf(values.minConfidence ?: "fair") ->
                (listOf("confidence is ${state.confidence}") + state.errors).joinToString()

            else -> "the head is not tracked"
        }
    }

    private companion object {
        const val REPEATED_AFTER_NANOS = 1_000_000_000L
    }
}
