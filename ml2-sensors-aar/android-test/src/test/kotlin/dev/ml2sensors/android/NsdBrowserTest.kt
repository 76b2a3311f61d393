package dev.ml2sensors.android

import android.app.Application
import android.net.nsd.NsdManager
import android.net.wifi.WifiManager
import app.cash.turbine.test
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import kotlinx.coroutines.runBlocking
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.shadow.api.Shadow
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertTrue

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE, shadows = [FakeNsdManager::class])
class NsdBrowserTest {
    private val app: Application = RuntimeEnvironment.getApplication()
    private val wifi = app.getSystemService(WifiManager::class.java)
    private val manager = Shadow.newInstanceOf(NsdManager::class.java)
    private val network = Shadow.extract<FakeNsdManager>(manager)
    private val browser = NsdBrowser(manager, wifi)
    private val desk = "desk" to ReceiverAddress("192.168.1.5", 7755)
    private val robot = "robot" to ReceiverAddress("fd00:0:0:0:0:0:0:7", 7756)

    @Test
    fun receiversComeAndGo() = runBlocking {
        browser.receivers().test {
            network.appear("desk", "192.168.1.5", 7755)
            assertEquals(mapOf(desk), awaitItem())
            network.appear("robot", "fd00::7", 7756)
            assertEquals(mapOf(desk, robot), awaitItem())
            network.vanish("desk")
            assertEquals(mapOf(robot), awaitItem())
            cancel()
        }
        assertEquals("_ml2sensors._tcp", network.type)
    }

    @Test
    fun thoseSeenAtOnceAreResolvedOneAfterTheOther() = runBlocking {
        network.isSlow = true
        browser.receivers().test {
            network.appear("desk", "192.168.1.5", 7755)
            network.appear("robot", "fd00::7", 7756)
            network.resolveNext()
            assertEquals(mapOf(desk), awaitItem())
            network.resolveNext()
            assertEquals(mapOf(desk, robot), awaitItem())
            cancel()
        }
    }

    @Test
    fun theSearchAndItsLockEndWithTheCollection() = runBlocking {
        browser.receivers().test {
            network.appear("desk", "192.168.1.5", 7755)
            awaitItem()
            assertTrue(network.isSearching)
            assertEquals(1, shadowOf(wifi).activeLockCount)
            cancel()
        }
        assertFalse(network.isSearching)
        assertEquals(0, shadowOf(wifi).activeLockCount)
    }

    @Test
    fun oneThatHasGoneBeforeItIsResolvedIsNone() = runBlocking {
        network.unresolvable += "desk"
        browser.receivers().test {
            network.appear("desk", "192.168.1.5", 7755)
            assertEquals(emptyMap(), awaitItem())
            cancel()
        }
    }

    @Test
    fun aSearchThatCannotBeginIsAFailure() = runBlocking {
        network.refusal = NsdManager.FAILURE_MAX_LIMIT
        browser.receivers().test {
            assertTrue("error 4" in "${assertIs<IOException>(awaitError())}")
        }
        assertEquals(0, shadowOf(wifi).activeLockCount)
    }

    @Test
    fun aReceiverIsLocatedByItsName() = runBlocking {
        network.appear("desk", "192.168.1.5", 7755)
        network.appear("robot", "fd00::7", 7756)
        assertEquals(robot.second, Receiver.discover(browser, "robot").locate())
    }
}
