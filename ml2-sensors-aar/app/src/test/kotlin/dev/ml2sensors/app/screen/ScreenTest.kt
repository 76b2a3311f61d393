package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.appStatus
import dev.ml2sensors.app.status.streamStatus
import dev.ml2sensors.wire.Status
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNull
import kotlin.test.assertTrue

class ScreenTest {
    @Test
    fun theTitleSaysWhereItStands() {
        val titles = mapOf(
            appStatus("off", paired = emptyList()) to Text(R.string.not_paired),
            appStatus("off") to Text(R.string.off),
            appStatus("connecting") to Text(R.string.connecting),
            appStatus("connected") to Text(R.string.connected, "desk"),
        )
        for ((status, title) in titles) assertEquals(title, screen(status).title)
        assertFalse(screen(appStatus("off")).isOn)
        assertTrue(screen(appStatus("connecting")).isOn)
    }

    @Test
    fun newsComesBeforeTheReason() {
        assertEquals("no route", screen(appStatus("connecting", reason = "no route")).detail)
        assertEquals("wrong code", screen(appStatus("connecting", reason = "no route", news = "wrong code")).detail)
    }

    @Test
    fun aStreamShowsItsRateAndWhatIsLostOrWhyItDoesNotRun() {
        val streams = listOf(
            streamStatus("world_left"),
            streamStatus("depth", dropped = 3),
            streamStatus("color", resting = true),
            streamStatus("gaze", state = "refused", reason = "permission missing"),
            streamStatus("battery"),
        )
        val rates = mapOf("world_left" to 30.0, "depth" to 5.0, "color" to 0.0)
        val rows = Screen.of(appStatus(streams = streams), rates, emptySet()).rows
        val expected = listOf(
            Screen.Row("world_left", Text(R.string.rate, 30.0), isBad = false),
            Screen.Row("depth", Text(R.string.rate_and_loss, 5.0, 3L), isBad = true),
            Screen.Row("color", Text(R.string.resting), isBad = true),
            Screen.Row("gaze", Text(R.string.bare, "permission missing"), isBad = true),
            Screen.Row("battery", Text(R.string.stream_begins), isBad = false),
        )
        assertEquals(expected, rows)
    }

    @Test
    fun theClockIsAsGoodAsItsUncertainty() {
        assertNull(screen(appStatus()).clock)
        assertEquals(Text(R.string.clock_waiting), screen(appStatus(clock = clock("waiting"))).clock)
        assertEquals(Text(R.string.clock, 0.25), screen(appStatus(clock = clock("synchronised"))).clock)
    }

    @Test
    fun heatIsAndroidsWordAndTheBatterysTemperature() {
        assertEquals(Text(R.string.heat, "severe"), screen(appStatus(thermal = "severe")).heat)
        assertEquals(Text(R.string.heat, "?"), screen(appStatus(thermal = null)).heat)
        assertEquals(Text(R.string.heat_and_battery, "none", 31.5), screen(appStatus(batteryCelsius = 31.5)).heat)
    }

    private fun clock(state: String) = Status.Clock(state, 0, 250_000, 500_000)

    private fun screen(status: AppStatus) = Screen.of(status, emptyMap(), emptySet())
}
