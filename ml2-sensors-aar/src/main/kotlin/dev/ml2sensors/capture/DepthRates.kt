package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.table.StreamSpec
import kotlin.math.abs

/**
 * Queries the rates that the depth camera of the vendor's SDK offers under the present light: 50 Hz mains exclude 30
 * and 60 Hz, 60 Hz mains exclude 25 and 50 Hz. It opens the camera briefly, once per range. Thread-safe.
 */
internal class DepthRates {
    private val known = HashMap<Int?, List<Int>>()

    /** Returns [answer], or an adjusted one with the nearest rate if the camera does not offer the requested rate. */
    fun adjust(stream: StreamSpec, requested: StreamValues, answer: Answer): Answer {
        val values = when (answer) {
            is Answer.Applied -> answer.values
            is Answer.Adjusted -> answer.values
            is Answer.Refused -> return answer
        }
        val rates = offeredRates(stream, values) ?: return answer
        val requestedHz = requested.rateHz
        if (requestedHz == null || values.rateHz in rates) return answer
        val nearest = rates.filter { stream.answer(values.copy(rateHz = it)) is Answer.Applied }
            .minByOrNull { abs(it - requestedHz) } ?: return answer
        val offered = "in the present mains-powered light the depth camera offers ${rates.joinToString()}"
        return Answer.Adjusted(values.copy(rateHz = nearest), "update_rate $requestedHz: $offered")
    }

    @Synchronized
    private fun offeredRates(stream: StreamSpec, values: StreamValues): List<Int>? =
        known[values.stream] ?: queryRates(stream, values)?.also { known[values.stream] = it }

    /** Returns null if the camera cannot be opened; opening the stream then reports the error. */
    private fun queryRates(stream: StreamSpec, values: StreamValues): List<Int>? = try {
        val bits = listOf(stream).bits()
        val second = if (values.stream == 1) bits else 0
        val handle =
            NativeSettings(PixelSensor.DEPTH.code, NativeBackend.SDK.code, bits, second, rateHz = SAFE_RATE_HZ).open()
        try {
            Native.listRates(handle).toList()
        } finally {
            Native.close(handle)
        }
    } catch (_: CaptureException) {
        null
    }

    private companion object {
        const val SAFE_RATE_HZ = 5
    }
}
