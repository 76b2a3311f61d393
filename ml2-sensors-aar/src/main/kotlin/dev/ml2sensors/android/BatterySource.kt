package dev.ml2sensors.android

import android.content.BroadcastReceiver
import android.content.Context
import android.content.Intent
import android.content.IntentFilter
import android.os.BatteryManager
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.map

/** Delivers the state of the battery when collection begins, and whenever Android reports a change. */
internal class BatterySource(
    private val context: Context,
    private val clock: DeviceClock,
    private val calls: PlatformCalls = PlatformCalls(),
) : SensorSource {
    private val access = SensorAccess(calls)

    override val backend: String get() = "battery_manager"

    override val streams: Set<StreamSpec> = setOf(StreamTable.battery)

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = Answer.Applied(requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        access.callbackSamples("$stream") { queue ->
            val receiver = object : BroadcastReceiver() {
                override fun onReceive(context: Context, intent: Intent) = queue.offer(sample(intent))
            }
            context.registerReceiver(receiver, IntentFilter(Intent.ACTION_BATTERY_CHANGED))
            AutoCloseable { context.unregisterReceiver(receiver) }
        }.map { if (it is BatterySample) it.withCurrent() else it }

    override fun pause(): Unit = access.pause()

    override fun resume(): Unit = access.resume()

    /** Ends all flows. */
    override fun close(): Unit = access.close()

    private fun sample(intent: Intent) = BatterySample(
        clock.nowNanos(),
        voltage = intent.number(BatteryManager.EXTRA_VOLTAGE) / MILLIVOLTS_PER_VOLT,
        current = Float.NaN,
        percentage = intent.percentage(),
        status = chargeStatus(intent.getIntExtra(BatteryManager.EXTRA_STATUS, UNKNOWN)),
        temperature = intent.number(BatteryManager.EXTRA_TEMPERATURE) / TENTHS_PER_DEGREE,
    )

    /** Returns the share of the scale, or not a number if level and scale give none: a level of -1 is unknown. */
    private fun Intent.percentage(): Float {
        val share = number(BatteryManager.EXTRA_LEVEL) / number(BatteryManager.EXTRA_SCALE)
        return if (share in 0f..1f) share else Float.NaN
    }

    private fun chargeStatus(status: Int) = when (status) {
        BatteryManager.BATTERY_STATUS_CHARGING -> ChargeStatus.CHARGING
        BatteryManager.BATTERY_STATUS_DISCHARGING -> ChargeStatus.DISCHARGING
        BatteryManager.BATTERY_STATUS_NOT_CHARGING -> ChargeStatus.NOT_CHARGING
        BatteryManager.BATTERY_STATUS_FULL -> ChargeStatus.FULL
        else -> ChargeStatus.UNKNOWN
    }

    private fun Intent.number(extra: String): Float =
        getIntExtra(extra, UNKNOWN).let { if (it == UNKNOWN) Float.NaN else it.toFloat() }

    /** Asked for by the collector, since the app's main thread receives the rest. */
    private fun BatterySample.withCurrent() =
        BatterySample(captureNanos, voltage, currentAmperes(), percentage, status, temperature)

    /** Android has the sign of [BatterySample]: negative when discharging. */
    private fun currentAmperes(): Float {
        val microamperes = try {
            calls.call("the battery's current") {
                context.getSystemService(BatteryManager::class.java)
                    .getLongProperty(BatteryManager.BATTERY_PROPERTY_CURRENT_NOW)
            }
        } catch (_: NoAnswerException) {
            Long.MIN_VALUE
        }
        return if (microamperes == Long.MIN_VALUE) Float.NaN else microamperes / MICROAMPERES_PER_AMPERE
    }

    private companion object {
        const val UNKNOWN = Int.MIN_VALUE
        const val MILLIVOLTS_PER_VOLT = 1e3f
        const val TENTHS_PER_DEGREE = 10f
        const val MICROAMPERES_PER_AMPERE = 1e6f
    }
}
