package dev.ml2sensors.app.thermal

import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.Thermal
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.takeWhile
import java.util.concurrent.ConcurrentHashMap
import kotlin.time.Duration.Companion.seconds

/** Wraps [headset] and pauses its cameras by [ThermalPolicy] while [isEnabled]. A paused camera is closed. */
internal class ThermalHeadset(private val headset: Headset, private val isEnabled: () -> Boolean) : Headset by headset {
    private val pausedIds: MutableSet<String> = ConcurrentHashMap.newKeySet()

    /** The ids of the streams that are paused now. */
    val paused: Set<String> get() = pausedIds

    override val holds: Map<String, String>
        get() = headset.holds + pausedIds.associateWith { "paused while the headset is hot" }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        val samples = headset.samples(stream, values)
        val limit = ThermalPolicy.limit(stream) ?: return samples
        return flow {
            do {
                if (isTooHot(limit)) pause(stream)
                var mustPause = false
                val cool = samples.takeWhile {
                    mustPause = isTooHot(limit)
                    !mustPause
                }
                emitAll(cool)
            } while (mustPause)
        }
    }

    private suspend fun pause(stream: StreamSpec) {
        pausedIds += stream.id
        try {
            while (isEnabled() && !ThermalPolicy.mayResume(headset.thermal)) delay(POLL_INTERVAL)
        } finally {
            pausedIds -= stream.id
        }
    }

    private fun isTooHot(limit: Thermal) = isEnabled() && headset.thermal.let { it != null && it >= limit }

    private companion object {
        val POLL_INTERVAL = 1.seconds
    }
}
