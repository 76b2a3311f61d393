package dev.ml2sensors.simulator.simulated

/**
 * A key of the simulation, as native/sim/settings.cpp and native/sim/openxr/keys.cpp declare it.
 *
 * @property value the current value.
 * @property isText true if the key takes one of [choices], or any text if there are none; other keys take numbers in
 *   [range].
 * @property isWhole true if the key takes whole numbers only.
 */
internal data class SimulationKey(
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
        /** The streams that deliver nothing although their sources are open; of the headset, not of its native code. */
        val silent: SimulationKey =
            text("fault.silent", "these streams deliver nothing: ids, with commas between")

        /** Returns a key of the headset, not of its native code, that takes any text. */
        fun text(name: String, meaning: String): SimulationKey = SimulationKey(
            name,
            value = "",
            default = "",
            isText = true,
            isWhole = false,
            range = 0.0..0.0,
            choices = emptyList(),
            meaning,
        )

        /** Returns all keys of native code in the order of their table. [NativeBundle] must have been loaded. */
        fun all(): List<SimulationKey> = SimulatedSdk.describeKeys().lines().filter(String::isNotEmpty).map(::parse)

        private fun parse(line: String): SimulationKey {
            val columns = line.split('\t')
            val (name, value, default, kind) = columns
            val (least, most, choices, meaning) = columns.takeLast(LAST_COLUMNS)
            return SimulationKey(
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
