package dev.ml2sensors.source

import dev.ml2sensors.TEST_LIMIT
import org.junit.jupiter.api.Test
import java.io.IOException
import java.util.concurrent.CountDownLatch
import java.util.concurrent.Future
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import java.util.concurrent.atomic.AtomicInteger
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds

class PlatformCallsTest {
    /** Has patience with all but what is held, however busy the machine is. */
    private open class Calls : PlatformCalls(limit = 50.milliseconds) {
        var isHeld = false

        override fun <T> await(call: Future<T>, patience: Duration): T =
            super.await(call, if (isHeld) patience else TEST_LIMIT)
    }

    private val calls = Calls()

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
        calls.isHeld = true
        repeat(2) {
            val failure = assertFailsWith<NoAnswerException> {
                calls.call("opening", late::add) {
                    answer.await()
                    "open $it"
                }
            }
            assertTrue(failure.message.orEmpty().startsWith("opening: no answer within 50ms"), "$failure")
        }
        calls.isHeld = false
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
        calls.isHeld = true
        assertFailsWith<NoAnswerException> { calls.call("opening") { answer.await() } }
        calls.isHeld = false
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
        val begun = AtomicInteger()
        val calls = object : Calls() {
            override fun execute(call: Runnable) {
                begun.incrementAndGet()
                super.execute(call)
            }
        }
        calls.isHeld = true
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
        val undone = generateSequence { late.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS) }
        assertEquals(begun.get(), undone.take(begun.get()).distinct().count())
        calls.isHeld = false
        while (runCatching { calls.call("opening") {} }.isFailure) Thread.onSpinWait()
    }
}
