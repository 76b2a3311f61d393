package dev.ml2sensors.source

import dev.ml2sensors.table.Mode
import dev.ml2sensors.table.StreamSpec

/** Returns the answer of a source that supports every mode of the stream in the table. */
internal fun StreamSpec.answer(requested: StreamValues): Answer {
    var fitting = modes
    for ((key, value, legal) in requested.cameraKeys()) {
        val expected = fitting.flatMap(legal).distinct()
        fitting = fitting.filter { value in legal(it) }
        if (fitting.isEmpty() && modes.isNotEmpty()) {
            return Answer.Refused("$key is $value, expected one of ${expected.joinToString()}")
        }
    }
    if (requested.quality != null && requested.quality !in QUALITIES) {
        return Answer.Refused("quality is ${requested.quality}, expected $QUALITIES")
    }
    if (requested.bitRateMbit != null && requested.bitRateMbit !in BIT_RATES_MBIT) {
        return Answer.Refused("bit_rate_mbit is ${requested.bitRateMbit}, expected $BIT_RATES_MBIT")
    }
    return Answer.Applied(requested)
}

private val QUALITIES = 1..100
private val BIT_RATES_MBIT = 1..100

private fun StreamValues.cameraKeys(): List<Triple<String, Any?, (Mode) -> List<Any>>> = listOf(
    Triple("stream", stream) { listOf(it.stream) },
    Triple("format", format) { it.formats },
    Triple("resolution", "${width}x$height") { mode -> mode.resolutions.map { (w, h) -> "${w}x$h" } },
    Triple("update_rate", rateHz) { it.rates },
)
