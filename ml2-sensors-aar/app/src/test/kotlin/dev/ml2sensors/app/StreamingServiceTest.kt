package dev.ml2sensors.app

import android.app.Notification
import android.app.NotificationManager
import android.content.Intent
import android.net.wifi.WifiManager
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.table.StreamTable
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.shadows.ShadowLog
import org.robolectric.shadows.ShadowPowerManager
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29])
class StreamingServiceTest {
    private val paired = PairedApp()
    private val app = paired.app
    private val controller = Robolectric.buildService(StreamingService::class.java).create()
    private val service = controller.get()
    private val shadow = shadowOf(service)
    private var starts = 0

    @After
    fun close() {
        controller.destroy()
        paired.close()
    }

    @Test
    fun itStreamsInTheForegroundWithLocksUntilItIsStopped() {
        send(Command.START)
        val session = paired.session("""{"battery": {}}""")
        eventually("the notification") { title() == "Connected to scripted" }
        eventually("the locks") { isAwake() && wifiLocks() == 2 }
        send(Command.STOP)
        assertEquals("""{"reason":"stopped"}""", session.await(HostFrame.BYE).body.decodeToString())
        eventually("the end of the service") { shadow.isStoppedBySelf }
        assertFalse(isAwake())
        assertEquals(0, wifiLocks())
        assertEquals(listOf("""{"request":"1","more":0}""", """{"request":"2","more":0}"""), lines())
        service.onDestroy()
        assertNull(title())
    }

    @Test
    fun afterItsProcessDiedItResumes() {
        app.settings.isStreaming = true
        resume()
        paired.session("{}")
        assertFalse(shadow.isStoppedBySelf)
    }

    @Test
    fun afterItsProcessDiedItStopsIfTheUserHadStoppedIt() {
        resume()
        eventually("the end of the service") { shadow.isStoppedBySelf }
        assertFalse(app.streaming.isOn)
    }

    @Test
    fun whenDestroyedItEndsTheSessionWithBye() {
        send(Command.START)
        val session = paired.session("{}")
        service.onDestroy()
        session.await(HostFrame.BYE)
        assertTrue(app.settings.isStreaming, "the user had not stopped it")
    }

    @Test
    fun anUnpairedHeadsetReportsAnErrorAndStops() {
        app.filesDir.resolve("ml2-sensors-receivers.json").delete()
        send(Command.START)
        eventually("the end of the service") { shadow.isStoppedBySelf }
        assertTrue("ml2-receiver pair" in lines().single(), lines().single())
    }

    @Test
    fun aDamagedPairingFileIsReported() {
        app.filesDir.resolve("ml2-sensors-receivers.json").writeText("[]")
        send(Command.START)
        eventually("the end of the service") { shadow.isStoppedBySelf }
        assertTrue("damaged" in lines().single(), lines().single())
    }

    @Test
    fun invalidIntentsAreAnsweredAndChangeNothing() {
        val token = "5".repeat(32)
        send("dev.ml2sensors.app.DANCE")
        send(Command.PAIR)
        send(Command.PAIR) { putExtra("uri", "ml2s://desk:1?token=$token") }
        send(Command.RECEIVER) { putExtra("receiver", "desk:99999") }
        send(Command.AT_BOOT) { putExtra("on", "true") }
        send(Command.COOL_DOWN) { putExtra("request", 7) }
        eventually("all replies") { lines().size == 6 }
        for (line in lines()) {
            assertNotNull(json(line)["error"], line)
            assertFalse(token in line, line)
        }
        eventually("the end of the service") { shadow.isStoppedBySelf }
        assertFalse(app.settings.startAtBoot || app.settings.pauseWhenHot || app.settings.isStreaming)
        assertEquals("${paired.host.address}", app.settings.receiver)
    }

    @Test
    fun aFailedPairingIsReportedWithoutTheToken() {
        val token = "5".repeat(32)
        send(Command.PAIR) { putExtra("uri", "ml2s://127.0.0.1:1?fp=${"a".repeat(64)}&token=$token") }
        eventually("the end of the service") { shadow.isStoppedBySelf }
        assertTrue("no pairing with the receiver" in lines().single(), lines().single())
        assertFalse(token in lines().single())
    }

    @Test
    fun theStatusIsWrittenToLogcat() {
        send(Command.START)
        paired.session("""{"battery": {}, "world_left": {}}""")
        eventually("the streams") { app.streaming.status().streams.size == 2 }
        eventually("the reply to START") { lines().size == 1 }
        send(Command.STATUS)
        eventually("the status") { lines().any { "world_left" in it } }
        val (status, camera, battery) = lines().drop(1).map(::json)
        assertEquals("connected", status.getValue("status").jsonObject.text("state"))
        assertEquals("refused", camera.getValue("stream").jsonObject.text("state"))
        assertEquals("running", battery.getValue("stream").jsonObject.text("state"))
    }

    @Test
    fun settingsAreSaved() {
        send(Command.AT_BOOT) { putExtra("on", true) }
        send(Command.COOL_DOWN) { putExtra("on", true) }
        send(Command.RECEIVER) { putExtra("receiver", "127.0.0.1:7755") }
        eventually("all replies") { lines().size == 3 }
        val again = AppSettings(app)
        assertEquals(listOf(true, true), listOf(again.startAtBoot, again.pauseWhenHot))
        assertEquals("127.0.0.1:7755", again.receiver)
    }

    @Test
    fun streamsFollowTheirPermissionWhenItIsGrantedAndRevoked() {
        val permissions = StreamTable.all.flatMap { it.permissions }.distinct()
        for (permission in permissions) {
            val stream = StreamTable.all.first { permission in it.permissions }.id
            val denial = "permission $permission is not granted"
            send(Command.START)
            assertEquals(denial, answer(stream))
            shadowOf(app).grantPermissions(permission)
            send(Command.START)
            assertTrue(answer(stream) != denial, permission)
            // Android ends the process of an app whose permission is revoked, and starts the service again
            shadowOf(app).denyPermissions(permission)
            resume()
            assertEquals(denial, answer(stream))
            send(Command.STOP)
            eventually("the end") { !app.streaming.isOn }
        }
    }

    /** Returns the reason that the next session gives for [stream]. */
    private fun answer(stream: String): String {
        val session = paired.host.awaitHello()
        session.welcome(paired.host.received())
        return session.configure(1, """{"$stream": {}}""").getValue(stream).jsonObject.text("reason")
    }

    private fun send(action: String, extras: Intent.() -> Unit = {}) {
        val intent = StreamingService.intent(app, action).putExtra("request", "${++starts}").apply(extras)
        service.onStartCommand(intent, 0, starts)
    }

    private fun resume() {
        service.onStartCommand(null, 0, ++starts)
    }

    private fun title() = shadowOf(app.getSystemService(NotificationManager::class.java))
        .getNotification(shadow.lastForegroundNotificationId)?.extras?.getString(Notification.EXTRA_TITLE)

    private fun isAwake() = ShadowPowerManager.getLatestWakeLock()?.isHeld == true

    private fun wifiLocks() = shadowOf(app.getSystemService(WifiManager::class.java)).activeLockCount

    private fun lines() = ShadowLog.getLogsForTag(StreamingService.TAG).orEmpty().map { it.msg }

    private fun json(line: String): JsonObject = Json.parseToJsonElement(line).jsonObject

    private fun JsonObject.text(key: String) = getValue(key).jsonPrimitive.content
}
