package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.StreamStatus

/** A string resource and what stands in it. */
internal data class Text(val id: Int, val values: List<Any> = emptyList()) {
    constructor(id: Int, vararg values: Any) : this(id, values.toList())
}

/**
 * What the user sees of the app's status.
 *
 * @property detail why it is not connected, or what became of what the user did; may be empty.
 * @property isOn whether there is something to stop.
 */
internal data class Screen(
    val title: Text,
    val detail: String,
    val clock: Text?,
    val heat: Text,
    val rows: List<Row>,
    val question: Question?,
    val isOn: Boolean,
) {
    /** One stream; [isBad] asks for attention. */
    data class Row(val stream: String, val text: Text, val isBad: Boolean)

    companion object {
        fun of(status: AppStatus, rates: Map<String, Double>, declined: Set<String>): Screen = Screen(
            title(status),
            status.news.ifEmpty { status.reason },
            status.clock?.let { clock(it.state, it.uncertaintyNanos) },
            heat(status),
            status.streams.map { row(it, rates[it.id]) },
            Question.next(status, declined),
            isOn = status.state != "off",
        )

        private fun title(status: AppStatus): Text = when {
            status.state == "connected" -> Text(R.string.connected, status.receiver)
            status.state != "off" -> Text(R.string.connecting)
            status.paired.isEmpty() -> Text(R.string.not_paired)
            else -> Text(R.string.off)
        }

        private fun clock(state: String, uncertaintyNanos: Long): Text = when (state) {
            "waiting" -> Text(R.string.clock_waiting)
            else -> Text(R.string.clock, uncertaintyNanos / NANOS_PER_MILLI)
        }

        private fun heat(status: AppStatus): Text {
            val battery = status.batteryCelsius ?: return Text(R.string.heat, status.thermal ?: UNKNOWN)
            return Text(R.string.heat_and_battery, status.thermal ?: UNKNOWN, battery)
        }

        private fun row(stream: StreamStatus, rateHz: Double?): Row = when {
            stream.state != "accepted" -> Row(stream.id, Text(R.string.bare, stream.reason), isBad = true)
            stream.resting -> Row(stream.id, Text(R.string.resting), isBad = true)
            rateHz == null -> Row(stream.id, Text(R.string.stream_begins), isBad = false)
            stream.dropped == 0L -> Row(stream.id, Text(R.string.rate, rateHz), isBad = false)
            else -> Row(stream.id, Text(R.string.rate_and_loss, rateHz, stream.dropped), isBad = true)
        }

        private const val UNKNOWN = "?"
        private const val NANOS_PER_MILLI = 1e6
    }
}
