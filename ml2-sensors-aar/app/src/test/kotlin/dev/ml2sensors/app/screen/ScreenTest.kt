package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.robot.RobotStatus
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.appStatus
import dev.ml2sensors.app.status.streamStatus
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Time
import dev.ml2sensors.wire.Status
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNull
import kotlin.test.assertTrue

class ScreenTest {
    @Test
    fun theTitleShowsTheConnection() {
        val titles = mapOf(
            appStatus("off", paired = emptyList()) to StringResource(R.string.not_paired),
            appStatus("off") to StringResource(R.string.off),
            appStatus("connecting") to StringResource(R.string.connecting),
            appStatus("connected") to StringResource(R.string.connected, "desk"),
        )
        for ((status, title) in titles) assertEquals(title, screen(status).title)
        assertFalse(screen(appStatus("off")).isOn)
        assertTrue(screen(appStatus("connecting")).isOn)
    }

    @Test
    fun theLastResultComesBeforeTheReason() {
        assertEquals("no route", screen(appStatus("connecting", reason = "no route")).detail)
        assertEquals(
            "wrong code",
            screen(appStatus("connecting", reason = "no route", lastResult = "wrong code")).detail,
        )
    }

    @Test
    fun aStreamShowsItsRateAndLossesOrWhyItDoesNotRun() {
        val streams = listOf(
            streamStatus("world_left"),
            streamStatus("depth", dropped = 3),
            streamStatus("color", isPaused = true),
            streamStatus("gaze", state = "refused", reason = "permission missing"),
            streamStatus("battery"),
        )
        val rates = mapOf("world_left" to 30.0, "depth" to 5.0, "color" to 0.0)
        val rows = Screen.of(appStatus(streams = streams), rates, emptySet()).rows
        val expected = listOf(
            Screen.Row("world_left", StringResource(R.string.rate, 30.0), isWarning = false),
            Screen.Row("depth", StringResource(R.string.rate_and_loss, 5.0, 3L), isWarning = true),
            Screen.Row("color", StringResource(R.string.paused), isWarning = true),
            Screen.Row("gaze", StringResource(R.string.plain, "permission missing"), isWarning = true),
            Screen.Row("battery", StringResource(R.string.starting), isWarning = false),
        )
        assertEquals(expected, rows)
    }

    @Test
    fun theRobotsTagShowsItsPoseAndRateAndTheTargetTheirNumberOrWhyThereAreNone() {
        val tag = PoseStamped(
            Header(Time(1, 2u), "base_link"),
            Pose(Point(0.5, -0.25, 1.0), Quaternion(0.0, 0.0, 0.0, 1.0)),
        )
        val texts = mapOf(
            RobotStatus(null, 0, "", 0, "") to
                listOf(StringResource(R.string.starting) to false, StringResource(R.string.sent, 0L) to false),
            RobotStatus(tag, 40, "", 3, "") to listOf(
                StringResource(R.string.tag, 0.5, -0.25, 1.0, "base_link", 20.0) to false,
                StringResource(R.string.sent, 3L) to false,
            ),
            RobotStatus(tag, 40, "no rule", 3, "disabled") to listOf(
                StringResource(R.string.plain, "no rule") to true,
                StringResource(R.string.plain, "disabled") to true,
            ),
        )
        for ((robot, expected) in texts) {
            val screen = Screen.of(appStatus(robot = robot), mapOf("/tag_pose" to 20.0), emptySet())
            assertTrue(screen.hasRobot)
            assertEquals(listOf("/tag_pose", "/target_pose"), screen.rows.map { it.stream })
            assertEquals(expected, screen.rows.map { it.text to it.isWarning })
        }
        assertFalse(screen(appStatus()).hasRobot)
    }

    @Test
    fun theClockShowsItsUncertainty() {
        assertNull(screen(appStatus()).clock)
        assertEquals(StringResource(R.string.clock_waiting), screen(appStatus(clock = clock("waiting"))).clock)
        assertEquals(StringResource(R.string.clock, 0.25), screen(appStatus(clock = clock("synchronised"))).clock)
    }

    @Test
    fun heatShowsAndroidsStatusAndTheBatteryTemperature() {
        assertEquals(StringResource(R.string.heat, "severe"), screen(appStatus(thermal = "severe")).heat)
        assertEquals(StringResource(R.string.heat, "?"), screen(appStatus(thermal = null)).heat)
        assertEquals(
            StringResource(R.string.heat_and_battery, "none", 31.5),
            screen(appStatus(batteryCelsius = 31.5)).heat,
        )
    }

    private fun clock(state: String) = Status.Clock(state, 0, 250_000, 500_000)

    private fun screen(status: AppStatus) = Screen.of(status, emptyMap(), emptySet())
}
