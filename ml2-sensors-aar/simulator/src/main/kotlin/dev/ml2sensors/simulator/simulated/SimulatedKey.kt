package dev.ml2sensors.simulator.simulated

/**
 * A key of the simulation, as native/sim/settings.cpp and native/sim/openxr/keys.cpp declare it.
 *
 * @property value now.
 * @property isText takes one of [choices], or any text if there are none; all other keys take numbers of [range].
 * @property isWhole takes whole numbers only.
 */
internal data class SimulatedKey(
    val name: String,
    val value: String,
    val default: String,
    val isText: Boolean,
    val isWhole: Boolean,
    val range: ClosedRange<Double>,
    val choices: List<String>,
    val meaning: String,
) {
    companion object {
        /** All there are, in the order of the table; after [NativeBundle] was loaded. */
        fun all(): List<SimulatedKey> = SimulatedSdk.describeKeys().lines().filter(String::isNotEmpty).map(::parse)

        private fun parse(line: String): SimulatedKey {
            val columns = line.split('\t')
            val (name, value, default, kind) = columns
            val (least, most, choices, meaning) = columns.takeLast(LAST_COLUMNS)
            return SimulatedKey(
                name,
                value,
                default,
                isText = kind == "text",
                isWhole = kind == "whole",
                range = least.toDouble()..most.toDouble(),
                choices = if (choices.isEmpty()) emptyList() else choices.split('|'),
                meaning,
            )
        }

        private const val LAST_COLUMNS = 4
    }
}
