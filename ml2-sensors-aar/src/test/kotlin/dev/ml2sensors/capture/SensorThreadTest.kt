package dev.ml2sensors.capture

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.Test
import java.util.concurrent.CountDownLatch
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue

/** On a vendor's library whose calls do not return until the test says so. */
class SensorThreadTest {
    private val answer = CountDownLatch(1)
    private val calls = LinkedBlockingQueue<String>()
    private var hanging = ""
    private var failing = ""
    private val thread = SensorThread("test sensor", isUrgent = true) {
        call("open")
        object : OpenSensor {
            override fun configure(subscriptions: List<Subscription>) = call("configure")

            override fun deliver(subscriptions: List<Subscription>) = call("deliver")

            override fun close() = call("close")
        }
    }

    private fun call(name: String) {
        if (name != "deliver" || hanging == name) calls += name
        if (failing == name) throw CaptureException.VendorFailure("the first reason")
        if (hanging == name) answer.await()
    }

    private fun subscription() = Subscription(StreamTable.depth, StreamValues(), SampleQueue(1))

    @Test
    fun aVendorThatDoesNotReturnKeepsNobodyAndIsUsedAgainWhenItDoes() = runBlocking {
        for (name in listOf("open", "deliver", "close")) {
            val thread = SensorThreadTest().apply { hanging = name }
            thread.hangAndReturn()
        }
    }

    private suspend fun hangAndReturn() {
        val first = subscription()
        thread.subscribe(first) {}
        val begun = if (hanging == "close") "open" else hanging
        while (poll() != begun) Unit
        thread.unsubscribe(first)
        val failure = assertFailsWith<CaptureException.VendorFailure> { thread.subscribe(subscription()) {} }
        assertTrue("has not returned to the thread 'test sensor'" in failure.message.orEmpty(), "$failure")
        answer.countDown()
        while (poll() != "close") Unit
        while (runCatching { thread.subscribe(subscription()) {} }.isFailure) Thread.onSpinWait()
        while (poll() != "open") Unit
        thread.close()
        while (poll() != "close") Unit
    }

    @Test
    fun aSensorThatFailsAndDoesNotCloseKeepsItsFirstReason() = runBlocking {
        failing = "deliver"
        hanging = "close"
        val first = subscription()
        thread.subscribe(first) {}
        while (poll() != "close") Unit
        thread.unsubscribe(first)
        val failure = assertFailsWith<CaptureException.VendorFailure> { thread.subscribe(subscription()) {} }
        assertTrue(failure.message.orEmpty().startsWith("the first reason; the vendor's library has not"), "$failure")
        answer.countDown()
        thread.close()
    }

    @Test
    fun closingReturnsThoughTheVendorDoesNot() {
        hanging = "open"
        thread.subscribe(subscription()) {}
        assertEquals("open", poll())
        thread.close()
        answer.countDown()
        assertEquals("close", poll())
    }

    private fun poll(): String? = calls.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS)
}
