package dev.ml2sensors.app

import android.content.Intent
import dev.ml2sensors.app.control.Command
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import kotlin.test.assertEquals
import kotlin.test.assertNull

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29])
class BootReceiverTest {
    private val app = RuntimeEnvironment.getApplication() as App

    @Test
    fun theServiceStartsAtBootIfEnabled() {
        app.settings.startAtBoot = true
        assertEquals(Command.START, startedBy(Intent.ACTION_BOOT_COMPLETED)?.action)
    }

    @Test
    fun theServiceDoesNotStartAtBootIfDisabled() = assertNull(startedBy(Intent.ACTION_BOOT_COMPLETED))

    @Test
    fun otherIntentsDoNotStartIt() {
        app.settings.startAtBoot = true
        assertNull(startedBy("dev.ml2sensors.app.START"))
    }

    private fun startedBy(action: String): Intent? {
        BootReceiver().onReceive(app, Intent(action))
        return shadowOf(app).nextStartedService
    }
}
