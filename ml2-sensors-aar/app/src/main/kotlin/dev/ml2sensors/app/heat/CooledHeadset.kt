package dev.ml2sensors.app.heat

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

/** [headset], whose cameras rest as [Cooling] says, if the user [isWilling]. A camera that rests is closed. */
internal class CooledHeadset(private val headset: Headset, private val isWilling: () -> Boolean) : Headset by headset {
    private val atRest: MutableSet<String> = ConcurrentHashMap.newKeySet()

    /** Ids of the streams that rest now. */
    val resting: Set<String> get() = atRest

    override val holds: Map<String, String>
        get() = headset.holds + atRest.associateWith { "it rests while the headset is hot" }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        val samples = headset.samples(stream, values)
        val limit = Cooling.limit(stream) ?: return samples
        return flow {
            do {
                if (isTooHot(limit)) rest(stream)
                var mustRest = false
                val cool = samples.takeWhile {
                    mustRest = isTooHot(limit)
                    !mustRest
                }
                emitAll(cool)
            } while (mustRest)
        }
    }

    private suspend fun rest(stream: StreamSpec) {
        atRest += stream.id
        try {
            while (isWilling() && !Cooling.isOver(headset.thermal)) delay(LOOK_AGAIN)
        } finally {
            atRest -= stream.id
        }
    }

    private fun isTooHot(limit: Thermal) = isWilling() && headset.thermal.let { it != null && it >= limit }

    private companion object {
        val LOOK_AGAIN = 1.seconds
    }
}
