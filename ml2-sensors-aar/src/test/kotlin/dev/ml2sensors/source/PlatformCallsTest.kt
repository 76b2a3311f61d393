package dev.ml2sensors.source

import dev.ml2sensors.TEST_LIMIT
import org.junit.jupiter.api.Test
import java.io.IOException
import java.util.concurrent.CountDownLatch
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.milliseconds

class PlatformCallsTest {
    private val calls = PlatformCalls(limit = 50.milliseconds)

    @Test
    fun aCallReturnsAndThrowsWhatThePlatformDoes() {
        assertEquals(3, calls.call("counting") { 3 })
        val failure = assertFailsWith<SecurityException> { calls.call("asking") { throw SecurityException("no") } }
        assertEquals("no", failure.message)
    }

    @Test
    fun aCallThatDoesNotReturnFailsAndThoseAfterItAtOnceUntilItDoes() {
        val answer = CountDownLatch(1)
        val late = LinkedBlockingQueue<String>()
        repeat(2) {
            val failure = assertFailsWith<NoAnswerException> {
                calls.call("opening", late::add) {
                    answer.await()
                    "open $it"
                }
            }
            assertTrue(failure.message.orEmpty().startsWith("opening: no answer within 50ms"), "$failure")
        }
        assertEquals("another", calls.call("asking") { "another" })
        answer.countDown()
        assertEquals("open 0", late.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS))
        assertEquals("open", calls.call("opening") { "open" })
        assertTrue(late.isEmpty())
    }

    @Test
    fun whatWasBegunIsEndedThoughAnEarlierCallIsNotAnswered() {
        val answer = CountDownLatch(1)
        val ended = CountDownLatch(1)
        assertFailsWith<NoAnswerException> { calls.call("opening") { answer.await() } }
        calls.end("opening", ended::countDown)
        assertEquals(0, ended.count)
        answer.countDown()
    }

    @Test
    fun anUndoingThatFailsDoesNotEndTheApp() {
        val answer = CountDownLatch(1)
        val uncaught = LinkedBlockingQueue<Throwable>()
        lateinit var thread: Thread
        val calls = object : PlatformCalls(limit = 50.milliseconds) {
            override fun execute(call: Runnable) {
                thread = Thread(call).apply {
                    setUncaughtExceptionHandler { _, e -> uncaught += e }
                    start()
                }
            }
        }
        assertFailsWith<NoAnswerException> {
            calls.call("opening", late = { throw IOException("it cannot be closed") }) { answer.await() }
        }
        answer.countDown()
        thread.join()
        assertEquals(emptyList(), uncaught.toList())
    }

    @Test
    fun everyLateResultIsUndone() {
        val answer = CountDownLatch(1)
        val late = LinkedBlockingQueue<Int>()
        val callers = List(8) { number ->
            Thread {
                runCatching {
                    calls.call("opening", late::add) {
                        answer.await()
                        number
                    }
                }
            }.apply { start() }
        }
        callers.forEach { it.join() }
        answer.countDown()
        val undone = generateSequence { late.poll(1, TimeUnit.SECONDS) }.toSet()
        assertTrue(undone.isNotEmpty())
        while (runCatching { calls.call("opening") {} }.isFailure) Thread.onSpinWait()
    }
}
