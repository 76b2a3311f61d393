package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.table.StreamSpec
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.Semaphore
import java.util.concurrent.TimeUnit
import kotlin.math.abs
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeMark
import kotlin.time.TimeSource

/**
 * Queries the rates that the depth camera of the vendor's SDK offers under the present light: 50 Hz mains exclude 30
 * and 60 Hz, 60 Hz mains exclude 25 and 50 Hz. It opens the camera briefly, once per range. While the camera cannot be
 * opened, its rates are unknown: a stream that depends on them is refused, and the camera is asked again after a pause
 * that grows up to [LONGEST_PAUSE]. One thread at a time asks it, since it has one client. Thread-safe.
 */
internal class DepthRates(private val time: TimeSource = TimeSource.Monotonic) {
    private sealed interface Rates {
        class Known(val inHz: List<Int>) : Rates

        class Unknown(val refusal: Answer.Refused, val pause: Duration, val askAgain: TimeMark) : Rates
    }

    private val byRange = ConcurrentHashMap<Int, Rates>()
    private val turn = Semaphore(1)

    /**
     * Returns [answer], one with the nearest rate if the camera does not offer the requested rate, or a refusal while
     * the rates are unknown.
     */
    fun adjust(stream: StreamSpec, requested: StreamValues, answer: Answer): Answer {
        val values = answer.acceptedValues ?: return answer
        val requestedHz = requested.rateHz
        if (requestedHz == null || requestedHz <= SAFE_RATE_HZ) return answer
        return when (val rates = rates(stream, values)) {
            is Rates.Unknown -> rates.refusal
            is Rates.Known -> nearest(rates.inHz, stream, values, requestedHz) ?: answer
        }
    }

    /** Returns the answer with the nearest of [ratesHz], or null if the rate of [values] can stay. */
    private fun nearest(ratesHz: List<Int>, stream: StreamSpec, values: StreamValues, requestedHz: Int): Answer? {
        if (values.rateHz in ratesHz) return null
        val nearest = ratesHz.filter { stream.answer(values.copy(rateHz = it)) is Answer.Applied }
            .minByOrNull { abs(it - requestedHz) } ?: return null
        val offered = "in the present mains-powered light the depth camera offers ${ratesHz.joinToString()}"
        return Answer.Adjusted(values.copy(rateHz = nearest), "update_rate $requestedHz: $offered")
    }

    private fun rates(stream: StreamSpec, values: StreamValues): Rates {
        val range = values.stream ?: LONG_RANGE
        if (!turn.tryAcquire(TURN_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS)) {
            return unknown("it has not answered an earlier question; if that lasts, restart the headset", null, null)
        }
        try {
            val last = byRange[range]
            if (last is Rates.Known || (last is Rates.Unknown && last.askAgain.hasNotPassedNow())) return last
            return query(stream, values, last as Rates.Unknown?).also { byRange[range] = it }
        } finally {
            turn.release()
        }
    }

    private fun query(stream: StreamSpec, values: StreamValues, last: Rates.Unknown?): Rates = try {
        val bits = listOf(stream).bits()
        val second = if (values.stream == 1) bits else 0
        val handle =
            NativeSettings(PixelSensor.DEPTH.code, NativeBackend.SDK.code, bits, second, rateHz = SAFE_RATE_HZ).open()
        try {
            Rates.Known(Native.listRates(handle).toList())
        } finally {
            Native.close(handle)
        }
    } catch (e: CaptureException) {
        unknown(e.message, stream.permissions.firstOrNull().takeIf { e is CaptureException.PermissionDenied }, last)
    }

    private fun unknown(cause: String?, permission: String?, last: Rates.Unknown?): Rates.Unknown {
        val pause = if (last == null) SHORTEST_PAUSE else minOf(last.pause * 2, LONGEST_PAUSE)
        val reason = "the depth camera cannot be asked yet for the rates that the light allows: $cause"
        return Rates.Unknown(Answer.Refused(reason, permission), pause, time.markNow() + pause)
    }

    private companion object {
        /** The camera offers rates up to this one in any light. */
        const val SAFE_RATE_HZ = 5
        const val LONG_RANGE = 0

        /** Many times what the camera takes to answer. */
        val TURN_LIMIT = 2.seconds

        val SHORTEST_PAUSE = 1.seconds
        val LONGEST_PAUSE = 16.seconds
    }
}
