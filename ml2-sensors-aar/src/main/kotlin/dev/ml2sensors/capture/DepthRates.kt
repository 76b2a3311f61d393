package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.table.StreamSpec
import kotlin.math.abs

/**
 * The rates that the depth camera of the vendor's SDK has here: light of 50 Hz mains excludes 30 and 60 Hz, that of
 * 60 Hz mains 25 and 50 Hz. The camera is opened for a moment to ask it, once per range. All methods may be called from
 * any thread.
 */
internal class DepthRates {
    private val known = HashMap<Int?, List<Int>>()

    /** [answer], or the nearest rate that the camera has here instead of one that it has not. */
    fun adjust(stream: StreamSpec, requested: StreamValues, answer: Answer): Answer {
        val values = when (answer) {
            is Answer.Applied -> answer.values
            is Answer.Adjusted -> answer.values
            is Answer.Refused -> return answer
        }
        val rates = here(stream, values) ?: return answer
        val wanted = requested.rateHz
        if (wanted == null || values.rateHz in rates) return answer
        val nearest = rates.filter { stream.answer(values.copy(rateHz = it)) is Answer.Applied }
            .minByOrNull { abs(it - wanted) } ?: return answer
        val reason = "update_rate $wanted: under the lights here the depth camera has ${rates.joinToString()}"
        return Answer.Adjusted(values.copy(rateHz = nearest), reason)
    }

    @Synchronized
    private fun here(stream: StreamSpec, values: StreamValues): List<Int>? =
        known[values.stream] ?: ask(stream, values)?.also { known[values.stream] = it }

    /** Null when the camera cannot be asked; whoever opens it then is told why. */
    private fun ask(stream: StreamSpec, values: StreamValues): List<Int>? = try {
        val bits = listOf(stream).bits()
        val second = if (values.stream == 1) bits else 0
        val handle =
            NativeSettings(PixelSensor.DEPTH.code, NativeBackend.SDK.code, bits, second, rateHz = ANYWHERE_HZ).open()
        try {
            Native.listRates(handle).toList()
        } finally {
            Native.close(handle)
        }
    } catch (_: CaptureException) {
        null
    }

    private companion object {
        const val ANYWHERE_HZ = 5
    }
}
