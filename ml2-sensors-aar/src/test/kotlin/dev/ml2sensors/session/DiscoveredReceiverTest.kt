package dev.ml2sensors.session

import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.test.currentTime
import kotlinx.coroutines.test.runTest
import org.junit.jupiter.api.Test
import java.io.IOException
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

class DiscoveredReceiverTest {
    private val desk = "desk" to ReceiverAddress("192.168.1.5", 7755)
    private val robot = "robot" to ReceiverAddress("192.168.1.6", 7755)

    @Test
    fun oneOfSeveralIsFoundByItsNameAsSoonAsItIsSeen() = runTest {
        val browser = browser(0.seconds to mapOf(desk), 1.seconds to mapOf(desk, robot))
        assertEquals(robot.second, Receiver.discover(browser, "robot").locate())
        assertEquals(1_000, currentTime)
    }

    @Test
    fun theOnlyOneNeedsNoName() = runTest {
        val browser = browser(0.seconds to mapOf(desk))
        assertEquals(desk.second, Receiver.discover(browser).locate())
        assertTrue(currentTime < 1_000, "a reconnection is not delayed by a second")
    }

    @Test
    fun severalWithoutANameAreListed() = runTest {
        val browser = browser(0.seconds to mapOf(robot), 120.milliseconds to mapOf(robot, desk))
        val failure = assertFailsWith<IOException> { Receiver.discover(browser).locate() }
        assertTrue("several" in "$failure" && "desk, robot" in "$failure", "$failure")
    }

    @Test
    fun namesThatAnybodyAnnouncesMoveNoCursorAndAreBounded() = runTest {
        val names = List(1000) { "desk\u001b]52;c;$it\u0007" }
        val failure = assertFailsWith<IOException> {
            Receiver.discover(browser(0.seconds to names.associateWith { desk.second })).locate()
        }
        val text = failure.message.orEmpty()
        assertTrue("several" in text && text.none(Char::isISOControl) && text.length < 600, text)
    }

    @Test
    fun anotherNameIsNotTaken() = runTest {
        val browser = browser(0.seconds to mapOf(desk))
        val failure = assertFailsWith<IOException> { Receiver.discover(browser, "robot").locate() }
        assertTrue("'robot', only desk" in "$failure", "$failure")
    }

    @Test
    fun noReceiverIsToldAfterAWhile() = runTest {
        val failure = assertFailsWith<IOException> { Receiver.discover(browser()).locate() }
        assertTrue("no receiver announces itself" in "$failure", "$failure")
    }

    @Test
    fun oneThatHasMovedIsFoundWhereItIsNow() = runTest {
        var host = "192.168.1.5"
        val receiver = Receiver.discover({
            flow {
                emit(mapOf("desk" to ReceiverAddress(host, 7755)))
                awaitCancellation()
            }
        })
        assertEquals("192.168.1.5", receiver.locate().host)
        host = "192.168.1.9"
        assertEquals("192.168.1.9", receiver.locate().host)
    }

    @Test
    fun anAddressIsLookedForNowhere() = runTest {
        assertEquals(desk.second, desk.second.locate())
    }

    /** Shows each of the [sights] at its time, and then no more. */
    private fun browser(vararg sights: Pair<Duration, Map<String, ReceiverAddress>>) = ReceiverBrowser {
        flow {
            var now = 0.seconds
            for ((time, receivers) in sights) {
                delay(time - now)
                now = time
                emit(receivers)
            }
            awaitCancellation()
        }
    }
}
