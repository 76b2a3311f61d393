package dev.ml2sensors.android

import android.Manifest
import android.os.Build
import android.os.PowerManager
import android.os.SystemClock
import android.provider.Settings
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DerivedStreamsHeadset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.Thermal
import dev.ml2sensors.table.StreamTable
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.util.ReflectionHelpers
import kotlin.test.assertContains
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertNotEquals

/** A device without libml2sensors.so and without any sensor, as far as Robolectric goes. */
@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE)
class Ml2SensorsTest {
    private val app = RuntimeEnvironment.getApplication()

    @Test
    fun everyStreamIsAnsweredWithAReasonAndNothingCrashes() {
        StreamTable.all.flatMap { it.permissions }.forEach { shadowOf(app).grantPermissions(it) }
        Ml2Sensors.open(app).use { headset ->
            val reasons = StreamTable.all.associateWith { headset.negotiate(it, StreamValues()) as? Answer.Refused }
            assertEquals("not available: libml2sensors.so", reasons[StreamTable.worldLeft]?.reason)
            assertEquals("not available: libml2sensors.so", reasons[StreamTable.gaze]?.reason)
            assertEquals("not available: libml2sensors.so", reasons[StreamTable.color]?.reason)
            assertEquals(
                "this headset lists no single Headset Left Gyroscope sensor; it lists: nothing",
                reasons[StreamTable.gyroLeft]?.reason,
            )
            assertEquals(null, reasons[StreamTable.battery])
        }
    }

    @Test
    fun openingReturnsThoughAndroidsServicesDoNotAndTheirStreamsComeWhenTheyDo() {
        val ends = HarshContext.CALLS_OF_OPENING.map(NeverReturns::hold)
        try {
            Ml2Sensors.open(HarshContext(app)).use { headset ->
                val asked = DerivedStreamsHeadset(headset)
                fun reason() = assertIs<Answer.Refused>(asked.negotiate(StreamTable.gyroLeft, StreamValues())).reason
                assertContains(reason(), "no answer within")
                assertEquals(null, headset.thermal)
                // Beside a question that waits, the others get so little time that a busy machine may need several.
                while (asked.negotiate(StreamTable.battery, StreamValues()) !is Answer.Applied) Thread.yield()
                ends.forEach { it() }
                while ("no answer" in reason()) Thread.yield()
                assertContains(reason(), "this headset lists no single Headset Left Gyroscope sensor")
                while (headset.thermal == null) Thread.yield()
                assertEquals(Thermal.NONE, headset.thermal)
            }
        } finally {
            NeverReturns.reset()
        }
    }

    @Test
    fun aHeadsetThatSleepsSaysSo() {
        val power = shadowOf(app.getSystemService(PowerManager::class.java))
        Ml2Sensors.open(app).use { headset ->
            assertEquals(null, headset.sleepReason)
            power.turnScreenOn(false)
            assertEquals("the headset is not worn, or asleep", headset.sleepReason)
        }
    }

    @Test
    fun permissionsAreThoseOfTheTable() {
        shadowOf(app).grantPermissions(Manifest.permission.CAMERA)
        Ml2Sensors.open(app).use { headset ->
            assertEquals(StreamTable.all.flatMap { it.permissions }.toSet(), headset.permissions.keys)
            assertEquals(listOf(Manifest.permission.CAMERA), headset.permissions.filterValues { it }.keys.toList())
            assertIs<Answer.Refused>(headset.negotiate(StreamTable.depth, StreamValues()))
        }
    }

    @Test
    fun theDeviceIsKnownByAHashThatIsAnotherForAnotherDevice() {
        ReflectionHelpers.setStaticField(Build::class.java, "MODEL", "Magic Leap 2")
        val ids = listOf("aaaa", "bbbb", "aaaa").map { androidId ->
            Settings.Secure.putString(app.contentResolver, Settings.Secure.ANDROID_ID, androidId)
            Ml2Sensors.open(app).use {
                assertEquals("Magic Leap 2", it.identity.name)
                assertFalse(androidId in it.identity.deviceId)
                it.identity.deviceId
            }
        }
        assertEquals(32, ids[0].length)
        assertEquals(ids[0], ids[2])
        assertNotEquals(ids[0], ids[1])
    }

    @Test
    fun itIsAsHotAsAndroidSays() {
        Ml2Sensors.open(app).use { headset ->
            val power = shadowOf(app.getSystemService(PowerManager::class.java))
            val grades = listOf(
                PowerManager.THERMAL_STATUS_NONE,
                PowerManager.THERMAL_STATUS_SEVERE,
                PowerManager.THERMAL_STATUS_SHUTDOWN,
            ).map {
                power.setCurrentThermalStatus(it)
                headset.thermal
            }
            assertEquals(listOf(Thermal.NONE, Thermal.SEVERE, Thermal.SHUTDOWN), grades)
        }
    }

    @Test
    fun itsClockIsElapsedRealtime() {
        Ml2Sensors.open(app).use { assertEquals(SystemClock.elapsedRealtimeNanos(), it.clock.nowNanos()) }
    }
}
