package dev.ml2sensors.android

import android.app.Application
import android.net.nsd.NsdManager
import android.net.wifi.WifiManager
import android.os.HandlerThread
import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.test
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.runTest
import kotlinx.coroutines.yield
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import org.robolectric.shadow.api.Shadow
import java.io.IOException
import java.util.concurrent.CopyOnWriteArrayList
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.milliseconds

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE, shadows = [FakeNsdManager::class, FakeMulticastLock::class])
class NsdBrowserTest {
    private val app: Application = RuntimeEnvironment.getApplication()
    private val wifi = app.getSystemService(WifiManager::class.java)
    private val manager = Shadow.newInstanceOf(NsdManager::class.java)
    private val network = Shadow.extract<FakeNsdManager>(manager)
    private val browser = NsdBrowser({ manager }, { wifi }, resolutionLimit = TEST_LIMIT)
    private val locks = FakeMulticastLock.held.apply { set(0) }
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
            assertEquals(1, locks.get())
            cancel()
        }
        assertFalse(network.isSearching)
        assertEquals(0, locks.get())
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
    fun aManagerThatDoesNotAnswerIsReplacedAndTheLastKnownAddressStandsMeanwhile() = runBlocking {
        val managers = List(2) { Shadow.newInstanceOf(NsdManager::class.java) }
        val networks = managers.map { Shadow.extract<FakeNsdManager>(it) }
        networks[0].appear("desk", "192.168.1.5", 7755)
        networks[1].appear("desk", "192.168.1.9", 7755)
        val browser = NsdBrowser(managers.iterator()::next, { wifi }, resolutionLimit = 50.milliseconds)
        browser.receivers().test {
            assertEquals(mapOf(desk), awaitItem())
            cancel()
        }
        networks[0].isSlow = true
        browser.receivers().test {
            assertEquals(mapOf(desk), awaitItem(), "the last known, while nothing is answered")
            assertEquals(mapOf("desk" to ReceiverAddress("192.168.1.9", 7755)), awaitItem(), "of a fresh manager")
            assertFalse(networks[0].isSearching)
            cancel()
        }
        assertEquals(listOf(false, false), networks.map { it.isSearching })
        assertEquals(0, locks.get())
    }

    @Test
    fun tenThousandSearchesThatFindNothingStartOneThread() = runTest(timeout = TEST_LIMIT) {
        // As Android's constructor does, which the shadow of this test replaces. Nothing ends this thread.
        val newManager = { manager.also { HandlerThread(THREAD).start() } }
        val anyReceiver = Receiver.discover(NsdBrowser(newManager, { wifi }))
        repeat(10_000) { assertFailsWith<IOException> { anyReceiver.locate() } }
        assertEquals(1, Thread.getAllStackTraces().keys.count { it.name == THREAD })
        network.appear("desk", "192.168.1.5", 7755)
        assertEquals(desk.second, anyReceiver.locate())
    }

    @Test
    fun managersThatNeverAnswerAreReplacedAFewTimesOnly() = runBlocking {
        val networks = mutableListOf<FakeNsdManager>()
        val newManager = {
            Shadow.newInstanceOf(NsdManager::class.java).also {
                networks += Shadow.extract<FakeNsdManager>(it).apply {
                    isSlow = true
                    appear("desk", "192.168.1.5", 7755)
                }
            }
        }
        val browser = NsdBrowser(newManager, { wifi }, resolutionLimit = 1.milliseconds)
        repeat(20) {
            browser.receivers().test {
                assertEquals(emptyMap(), awaitItem())
                cancelAndIgnoreRemainingEvents()
            }
        }
        assertEquals(8, networks.size)
        networks.last().isSlow = false
        networks.last().resolveNext()
        browser.receivers().test {
            assertEquals(mapOf(desk), awaitItem())
            cancel()
        }
    }

    @Test
    fun aManagerThatDoesNotReturnFromACallIsReplaced() = runBlocking {
        for (call in listOf("discoverServices", "stopServiceDiscovery", "resolveService")) {
            val networks = CopyOnWriteArrayList<FakeNsdManager>()
            val newManager = { newManager().also { networks += Shadow.extract<FakeNsdManager>(it) } }
            val browser = NsdBrowser(newManager, { wifi }, 50.milliseconds, HarshCalls())
            val answer = NeverReturns.hold("NsdManager.$call")
            when (call) {
                "discoverServices" -> assertFailsWith<NoAnswerException> { browser.receivers().first() }
                "resolveService" -> browser.receivers().first { networks.size > 1 }
                else -> assertEquals(mapOf(desk), browser.receivers().first())
            }
            answer()
            // Until the thread of the held call has ended, other calls have little time.
            while (runCatching { browser.receivers().first { it == mapOf(desk) } }.isFailure) yield()
            assertTrue(networks.size > 1, call)
            while (networks.any { it.isSearching } || locks.get() > 0) yield()
        }
    }

    @Test
    fun aManagerWhoseConstructorDoesNotReturnIsAFailureAndServesWhenItDoes() = runBlocking {
        val answer = NeverReturns.hold("NsdManager.constructor")
        val newManager = {
            NeverReturns.pass("NsdManager.constructor")
            newManager()
        }
        val browser = NsdBrowser(newManager, { wifi }, calls = HarshCalls())
        repeat(2) { assertFailsWith<NoAnswerException> { browser.receivers().first() } }
        answer()
        while (runCatching { assertEquals(mapOf(desk), browser.receivers().first()) }.isFailure) yield()
    }

    @Test
    fun aLockForMulticastThatIsNotAnsweredKeepsNoSearch() = runBlocking {
        network.appear("desk", "192.168.1.5", 7755)
        val browser = NsdBrowser({ manager }, { wifi }, calls = HarshCalls())
        for (call in listOf("acquire", "release")) {
            val answer = NeverReturns.hold("MulticastLock.$call")
            assertEquals(mapOf(desk), browser.receivers().first())
            answer()
        }
        while (locks.get() > 0) yield()
    }

    private fun newManager(): NsdManager = Shadow.newInstanceOf(NsdManager::class.java).also {
        Shadow.extract<FakeNsdManager>(it).appear("desk", "192.168.1.5", 7755)
    }

    @Test
    fun aResolutionThatASearchLeftBehindIsAwaitedByTheNext() = runBlocking {
        network.isSlow = true
        network.appear("desk", "192.168.1.5", 7755)
        val search = launch(start = CoroutineStart.UNDISPATCHED) { browser.receivers().collect {} }
        yield()
        search.cancelAndJoin()
        browser.receivers().test {
            network.resolveNext()
            network.resolveNext()
            assertEquals(mapOf(desk), awaitItem())
            cancel()
        }
    }

    @Test
    fun aSearchThatCannotBeginIsAFailure() = runBlocking {
        network.refusal = NsdManager.FAILURE_MAX_LIMIT
        browser.receivers().test {
            assertTrue("error 4" in "${assertIs<IOException>(awaitError())}")
        }
        assertEquals(0, locks.get())
    }

    @Test
    fun aReceiverIsLocatedByItsName() = runBlocking {
        network.appear("desk", "192.168.1.5", 7755)
        network.appear("robot", "fd00::7", 7756)
        assertEquals(robot.second, Receiver.discover(browser, "robot").locate())
    }

    private companion object {
        const val THREAD = "NsdManager of this test"
    }
}
