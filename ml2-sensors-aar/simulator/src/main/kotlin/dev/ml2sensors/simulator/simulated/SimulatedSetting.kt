package dev.ml2sensors.simulator.simulated

import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * A key of the simulated device, native/sim/settings.cpp, and the value it takes: before anything is opened, or [after]
 * so much time of samples.
 */
internal class SimulatedSetting(val key: String, val value: String, val after: Duration? = null) {
    override fun toString(): String = "$key=$value"

    companion object {
        private val SPELLING = Regex("""([^=]+)=(.*?)(?:@(\d+(?:\.\d+)?))?""")

        /** KEY=VALUE or KEY=VALUE@SECONDS; null if [text] is neither. */
        fun parse(text: String): SimulatedSetting? {
            val (key, value, seconds) = SPELLING.matchEntire(text)?.destructured ?: return null
            return SimulatedSetting(key, value, seconds.toDoubleOrNull()?.seconds)
        }
    }
}
