package dev.ml2sensors.android

import android.app.Application
import android.content.Intent
import android.os.BatteryManager
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.test
import kotlinx.coroutines.runBlocking
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE)
class BatterySourceTest {
    private val app: Application = RuntimeEnvironment.getApplication()
    private val source = BatterySource(app, clock = { 42 })

    @Test
    fun theStateIsThereAtOnceAndInSiUnits() = runBlocking {
        setCurrent(microamperes = -1_600_000)
        broadcast(BatteryManager.BATTERY_STATUS_DISCHARGING, level = 150)
        source.samples(StreamTable.battery, StreamValues()).test {
            val sample = battery(awaitItem())
            assertEquals(42, sample.captureNanos)
            assertEquals(7.7f, sample.voltage)
            assertEquals(-1.6f, sample.current)
            assertEquals(0.75f, sample.percentage)
            assertEquals(ChargeStatus.DISCHARGING, sample.status)
            assertEquals(31.5f, sample.temperature)
            broadcast(BatteryManager.BATTERY_STATUS_CHARGING, level = 160)
            assertEquals(ChargeStatus.CHARGING, battery(awaitItem()).status)
            cancel()
        }
        assertFalse(shadowOf(app).hasReceiverForIntent(Intent(Intent.ACTION_BATTERY_CHANGED)), "unregistered")
    }

    @Test
    fun whatAndroidDoesNotSayIsNotANumber() = runBlocking {
        setCurrent(Long.MIN_VALUE)
        app.sendStickyBroadcast(Intent(Intent.ACTION_BATTERY_CHANGED))
        source.samples(StreamTable.battery, StreamValues()).test {
            val sample = battery(awaitItem())
            assertEquals(
                List(4) { Float.NaN },
                listOf(sample.voltage, sample.current, sample.percentage, sample.temperature),
            )
            cancel()
        }
    }

    @Test
    fun aChargeThatIsNoShareOfTheScaleIsNotANumber() = runBlocking {
        setCurrent(Long.MIN_VALUE)
        for ((level, scale) in listOf(-1 to 100, 101 to 100, 50 to 0, 0 to 0, 50 to -100)) {
            val intent = Intent(Intent.ACTION_BATTERY_CHANGED)
                .putExtra(BatteryManager.EXTRA_LEVEL, level)
                .putExtra(BatteryManager.EXTRA_SCALE, scale)
            app.sendStickyBroadcast(intent)
            source.samples(StreamTable.battery, StreamValues()).test {
                assertEquals(Float.NaN, battery(awaitItem()).percentage, "$level of $scale")
                cancel()
            }
        }
    }

    @Test
    fun whatTheChargerDoesIsToldAsAndroidTellsIt() = runBlocking {
        setCurrent(Long.MIN_VALUE)
        val told = mapOf(
            BatteryManager.BATTERY_STATUS_UNKNOWN to ChargeStatus.UNKNOWN,
            BatteryManager.BATTERY_STATUS_CHARGING to ChargeStatus.CHARGING,
            BatteryManager.BATTERY_STATUS_DISCHARGING to ChargeStatus.DISCHARGING,
            BatteryManager.BATTERY_STATUS_NOT_CHARGING to ChargeStatus.NOT_CHARGING,
            BatteryManager.BATTERY_STATUS_FULL to ChargeStatus.FULL,
            99 to ChargeStatus.UNKNOWN,
        )
        app.sendStickyBroadcast(Intent(Intent.ACTION_BATTERY_CHANGED))
        source.samples(StreamTable.battery, StreamValues()).test {
            assertEquals(ChargeStatus.UNKNOWN, battery(awaitItem()).status, "an intent without a status")
            told.forEach { (status, expected) ->
                broadcast(status, level = 100)
                assertEquals(expected, battery(awaitItem()).status)
            }
            cancel()
        }
    }

    private fun battery(sample: Sample) = assertIs<BatterySample>(sample)

    private fun setCurrent(microamperes: Long) =
        shadowOf(app.getSystemService(BatteryManager::class.java))
            .setLongProperty(BatteryManager.BATTERY_PROPERTY_CURRENT_NOW, microamperes)

    @Suppress("DEPRECATION")
    private fun broadcast(status: Int, level: Int) {
        val intent = Intent(Intent.ACTION_BATTERY_CHANGED)
            .putExtra(BatteryManager.EXTRA_STATUS, status)
            .putExtra(BatteryManager.EXTRA_VOLTAGE, 7_700)
            .putExtra(BatteryManager.EXTRA_LEVEL, level)
            .putExtra(BatteryManager.EXTRA_SCALE, 200)
            .putExtra(BatteryManager.EXTRA_TEMPERATURE, 315)
        app.sendStickyBroadcast(intent)
        shadowOf(android.os.Looper.getMainLooper()).idle()
    }
}
