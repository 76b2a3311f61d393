package dev.ml2sensors.simulator.simulated

import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * A value for a key of the simulated device (native/sim/settings.cpp). It is set before the device is opened, or
 * [after] this time from the first sample.
 */
internal class SimulationSetting(val key: String, val value: String, val after: Duration? = null) {
    override fun toString(): String = "$key=$value"

    companion object {
        private val FORMAT = Regex("""([^=]+)=(.*?)(?:@(\d+(?:\.\d+)?))?""")

        /** Parses KEY=VALUE or KEY=VALUE@SECONDS. Returns null for any other [text]. */
        fun parse(text: String): SimulationSetting? {
            val (key, value, seconds) = FORMAT.matchEntire(text)?.destructured ?: return null
            return SimulationSetting(key, value, seconds.toDoubleOrNull()?.seconds)
        }
    }
}
