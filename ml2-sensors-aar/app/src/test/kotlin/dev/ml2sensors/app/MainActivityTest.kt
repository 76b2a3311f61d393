package dev.ml2sensors.app

import android.app.AlertDialog
import android.content.DialogInterface
import android.content.Intent
import android.content.pm.PackageManager
import android.net.Uri
import android.view.View
import android.widget.Button
import android.widget.CheckBox
import android.widget.EditText
import android.widget.TextView
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Time
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.Shadows.shadowOf
import org.robolectric.android.controller.ActivityController
import org.robolectric.annotation.Config
import org.robolectric.shadows.ShadowAlertDialog
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29])
class MainActivityTest {
    private val paired = PairedApp()
    private val app = paired.app
    private lateinit var controller: ActivityController<MainActivity>
    private lateinit var session: HostSession

    @After
    fun close() {
        if (::controller.isInitialized) controller.close()
        paired.close()
    }

    @Test
    fun theButtonStartsAndStopsStreaming() {
        open()
        eventually("the paired state") { text(R.id.title) == "Off" }
        button(R.id.toggle).performClick()
        assertEquals(Command.START, started()?.action)
        stream("{}")
        assertEquals("Connected to scripted", text(R.id.title))
        assertEquals("Stop", button(R.id.toggle).text)
        button(R.id.toggle).performClick()
        assertEquals(Command.STOP, started()?.action)
    }

    @Test
    fun anUnpairedHeadsetShowsThat() {
        app.filesDir.resolve("ml2-sensors-receivers.json").delete()
        open()
        assertEquals("Not paired", text(R.id.title))
    }

    @Test
    fun streamsAreShownWithRateOrReason() {
        open()
        stream("""{"battery": {}, "depth": {}}""")
        eventually("the rows") { rows().size == 2 }
        assertEquals("depth", rows()[0].first)
        assertTrue("is not granted" in rows()[0].second, rows()[0].second)
        eventually("a rate") { rows()[1].second.endsWith(" Hz") }
    }

    @Test
    fun theTagOfARobotIsShownAndItsArmIsSentThere() {
        open()
        stream("""{"custom": {}}""", ros = true)
        assertEquals(View.GONE, button(R.id.reach).visibility)
        view<CheckBox>(R.id.robot).performClick()
        session.await(HostFrame.CHANNEL)
        session.start(1)
        val open = session.await(HostFrame.OPEN).json
        assertEquals(listOf("/tag_pose", "geometry_msgs/msg/PoseStamped"), listOf("name", "type").map { open.text(it) })
        session.write(HostFrame.OPENED, """{"id": 1, "result": "opened", "lane": "ros", "latched": false}""")
        for (number in 0..9) session.message(1, number, Cdr.encodeToByteArray(PoseStamped.serializer(), tag(number)))
        eventually("the newest pose") {
            rows().any { (topic, it) -> topic == TAG && it.startsWith("0.50 -0.25 9.00 m") }
        }
        eventually("a target") {
            button(R.id.reach).performClick() // Nothing is sent while ROS time is not known
            session.data(TARGET).isNotEmpty()
        }
        val target = Cdr.decodeFromByteArray(PoseStamped.serializer(), session.data(TARGET).first().body)
        assertEquals("base_link" to tag(9).pose, target.header.frameId to target.pose)
        eventually("the count") {
            rows().any { (topic, it) -> topic == TARGET && it.endsWith(" sent") && it != "0 sent" }
        }
        view<CheckBox>(R.id.robot).performClick()
        session.await(HostFrame.CLOSE)
        eventually("no robot") { button(R.id.reach).visibility == View.GONE && rows().none { it.first == TAG } }
    }

    @Test
    fun aRobotThatTheReceiverDoesNotAllowSaysWhy() {
        app.settings.showRobot = true
        open()
        stream("{}", ros = true)
        session.await(HostFrame.OPEN)
        session.write(HostFrame.OPENED, """{"id": 1, "result": "refused", "reason": "no rule", "code": "rules"}""")
        eventually("the reason") { TAG to "/tag_pose: no rule" in rows() }
    }

    @Test
    fun permissionsAreRequestedOneByOneWithTheirReason() {
        open()
        stream("""{"depth": {}, "world_left": {}, "color": {}}""")
        eventually("the first request") { "world_left, color" in text(R.id.reason) }
        button(R.id.allow).performClick()
        assertEquals(listOf(CAMERA), asked())
        answer(CAMERA, PackageManager.PERMISSION_DENIED)
        eventually("the second request") { "depth" in text(R.id.reason) }
        controller.recreate()
        eventually("the second request, after a rotation") { "depth" in text(R.id.reason) }
        button(R.id.allow).performClick()
        assertEquals(listOf(DEPTH), asked())
        shadowOf(app).clearStartedServices()
        shadowOf(app).grantPermissions(DEPTH)
        answer(DEPTH, PackageManager.PERMISSION_GRANTED)
        assertEquals(Command.START, started()?.action, "start again with the permission")
        eventually("no more requests") { view<View>(R.id.permission_request).visibility == View.GONE }
    }

    @Test
    fun aPairingUriFromOutsideNeedsConfirmation() {
        open(view(URI))
        val dialog = assertNotNull(ShadowAlertDialog.getLatestAlertDialog())
        val message = shadowOf(dialog).message.toString()
        assertTrue("10.0.0.2" in message && FINGERPRINT in message, message)
        assertFalse(TOKEN in message, message)
        assertNull(started())
        press(dialog, DialogInterface.BUTTON_POSITIVE)
        val intent = assertNotNull(started())
        assertEquals(Command.PAIR to URI, intent.action to intent.getStringExtra("uri"))
    }

    @Test
    fun theDialogAndItsDismissalSurviveARotation() {
        open(view(URI))
        controller.recreate()
        val dialog = assertNotNull(ShadowAlertDialog.getLatestAlertDialog())
        assertTrue(dialog.isShowing)
        press(dialog, DialogInterface.BUTTON_NEGATIVE)
        controller.recreate()
        assertFalse(ShadowAlertDialog.getLatestAlertDialog().isShowing)
        assertNull(started())
    }

    @Test
    fun aPastedUriNeedsConfirmation() {
        open()
        view<EditText>(R.id.uri).setText(" $URI\n")
        button(R.id.pair).performClick()
        press(ShadowAlertDialog.getLatestAlertDialog(), DialogInterface.BUTTON_POSITIVE)
        assertEquals(URI, started()?.getStringExtra("uri"))
    }

    @Test
    fun invalidUrisCannotBeConfirmed() {
        open()
        for (bad in listOf(
            "",
            "ml2s://",
            "ml2s://desk:1?token=$TOKEN",
            "$URI&more=1",
            "http://desk",
            "x".repeat(100_000),
        )) {
            controller.newIntent(view(bad))
            val dialog = ShadowAlertDialog.getLatestAlertDialog()
            assertEquals("This is not a pairing URI", shadowOf(dialog).title, bad.take(20))
            assertFalse(TOKEN in shadowOf(dialog).message.toString())
            assertNull(dialog.getButton(DialogInterface.BUTTON_POSITIVE)?.takeIf { it.visibility == View.VISIBLE })
        }
        assertNull(started())
        controller.newIntent(Intent(Intent.ACTION_VIEW))
    }

    @Test
    fun checkBoxesChangeTheSettings() {
        app.settings.startAtBoot = true
        open()
        assertTrue(view<CheckBox>(R.id.at_boot).isChecked)
        view<CheckBox>(R.id.at_boot).performClick()
        view<CheckBox>(R.id.pause_when_hot).performClick()
        assertEquals(false to true, app.settings.startAtBoot to app.settings.pauseWhenHot)
    }

    @Test
    fun resumingTheActivityStartsAgainSoThatNewPermissionsAreUsed() {
        app.settings.isStreaming = true
        open()
        assertEquals(Command.START, started()?.action)
        controller.pause().resume()
        assertEquals(Command.START, started()?.action)
    }

    private fun tag(number: Int) = PoseStamped(
        Header(Time(1, 2u), "base_link"),
        Pose(Point(0.5, -0.25, number.toDouble()), Quaternion(0.0, 0.0, 0.0, 1.0)),
    )

    private fun JsonObject.text(key: String) = getValue(key).jsonPrimitive.content

    private fun open(intent: Intent? = null) {
        controller = Robolectric.buildActivity(MainActivity::class.java, intent).setup()
    }

    private fun view(uri: String) = Intent(Intent.ACTION_VIEW, Uri.parse(uri))

    /** Starts streaming, as the service does. */
    private fun stream(streams: String, ros: Boolean = false) {
        runBlocking { app.streaming.start() }
        session = paired.session(streams, ros)
        eventually("the connection") { text(R.id.title).startsWith("Connected") }
    }

    private fun answer(permission: String, result: Int) =
        controller.get().onRequestPermissionsResult(0, arrayOf(permission), intArrayOf(result))

    private fun asked() = shadowOf(controller.get()).lastRequestedPermission.requestedPermissions.toList()

    private fun press(dialog: AlertDialog, which: Int) {
        dialog.getButton(which).performClick()
        shadowOf(android.os.Looper.getMainLooper()).idle()
    }

    private fun started(): Intent? = shadowOf(app).nextStartedService

    private fun rows(): List<Pair<String, String>> {
        val rows = view<android.view.ViewGroup>(R.id.streams)
        return (0 until rows.childCount).map {
            val row = rows.getChildAt(it)
            "${row.findViewById<TextView>(R.id.stream).text}" to "${row.findViewById<TextView>(R.id.rate).text}"
        }
    }

    private fun <T : View> view(id: Int): T = controller.get().findViewById(id)

    private fun text(id: Int): String = view<TextView>(id).text.toString()

    private fun button(id: Int): Button = view(id)

    private companion object {
        const val TAG = "/tag_pose"
        const val TARGET = "/target_pose"
        const val CAMERA = "android.permission.CAMERA"
        const val DEPTH = "com.magicleap.permission.DEPTH_CAMERA"
        val FINGERPRINT = "a".repeat(64)
        val TOKEN = "5".repeat(32)
        val URI = "ml2s://10.0.0.2:7756?fp=$FINGERPRINT&token=$TOKEN"
    }
}
