package dev.ml2sensors.simulator.simulated

/**
 * A key of the simulation, as native/sim/settings.cpp declares it.
 *
 * @property value now.
 * @property isText takes any text; all others take numbers of [range].
 * @property isWhole takes whole numbers only.
 */
internal data class SimulatedKey(
    val name: String,
    val value: String,
    val default: String,
    val isText: Boolean,
    val isWhole: Boolean,
    val range: ClosedRange<Double>,
    val meaning: String,
) {
    companion object {
        /** All there are, in the order of the table; after [NativeBundle] was loaded. */
        fun all(): List<SimulatedKey> = SimulatedSdk.describeKeys().lines().filter(String::isNotEmpty).map(::parse)

        private fun parse(line: String): SimulatedKey {
            val columns = line.split('\t')
            val (name, value, default, kind) = columns
            val (least, most, meaning) = columns.takeLast(LAST_COLUMNS)
            val range = least.toDouble()..most.toDouble()
            return SimulatedKey(name, value, default, kind == "text", kind == "whole", range, meaning)
        }

        private const val LAST_COLUMNS = 3
    }
}
