package dev.ml2sensors.stream

import dev.ml2sensors.source.Condition
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.wire.Event
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.onCompletion
import kotlinx.coroutines.flow.onEach
import java.util.concurrent.ConcurrentHashMap

/** Keeps how well the headset perceives now, by the names of PROTOCOL.md. Thread-safe, but each name has one stream. */
internal class Conditions(private val report: (Event) -> Unit) {
    private val latest = ConcurrentHashMap<String, Condition>()
    private var lastGaze: Condition? = null

    fun toBodies(): Map<String, Status.Condition> =
        latest.mapValues { (_, it) -> Status.Condition.of(it.isGood, it.message, it.values) }

    /** Takes over what [samples] say until they end. */
    fun watch(name: String, samples: Flow<Sample>): Flow<Sample> =
        samples.onEach { if (it is PoseSample) set(name, it.condition) }.onCompletion { set(name, null) }

    /** Takes over a condition; null ends the one before. */
    fun set(name: String, condition: Condition?) {
        if (condition == null) {
            latest.remove(name)
        } else {
            latest[name] = condition
            if (name == GAZE) reportGaze(condition)
        }
    }

    /** Reports each change of the gaze. One that is good from the start is no news. */
    private fun reportGaze(condition: Condition) {
        val before = lastGaze
        if (Condition.NOT_SAID in condition.values.values || condition == before) return
        lastGaze = condition
        if (condition.isGood && before == null) return
        val name = if (condition.isGood) Event.GAZE_RELIABLE else Event.GAZE_UNRELIABLE
        report(Event(name, "gaze: ${condition.message}"))
    }

    companion object {
        const val TRACKING = "tracking"
        const val GAZE = "gaze"
        const val MAP = "map"
    }
}
