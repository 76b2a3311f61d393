package dev.ml2sensors.source

import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.ExecutionException
import java.util.concurrent.Future
import java.util.concurrent.FutureTask
import java.util.concurrent.SynchronousQueue
import java.util.concurrent.ThreadPoolExecutor
import java.util.concurrent.TimeUnit
import java.util.concurrent.TimeoutException
import java.util.concurrent.atomic.AtomicBoolean
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/** The platform has not returned from a call. */
internal class NoAnswerException(what: String, limit: Duration) :
    SourceException("$what: no answer within $limit; if that lasts, restart the headset")

/**
 * Calls into the platform, each of which may never return. The caller waits on its own thread, for [limit] at most, and
 * only [IMPATIENT] while another call is not answered. Such a call keeps its thread, and calls for the same `what` fail
 * at once until it returns. Thread-safe.
 */
internal open class PlatformCalls(private val limit: Duration = LIMIT) {
    /** The number of calls that have not returned in time, by name. */
    private val unanswered = ConcurrentHashMap<String, Int>()

    /**
     * Returns what [action] returns, or throws what it throws.
     *
     * @param what names the call.
     * @param late receives the result that comes after the limit, on another thread, so that it can be undone.
     * @throws NoAnswerException after the limit.
     */
    fun <T> call(what: String, late: (T) -> Unit = {}, action: () -> T): T {
        if (unanswered.containsKey(what)) throw NoAnswerException(what, limit)
        return result(Call(what, late, action))
    }

    /**
     * Ends by [action] what a [call] for the same [what] began. Is carried out in any case, else that would be left.
     *
     * @throws NoAnswerException after the limit.
     */
    fun end(what: String, action: () -> Unit): Unit = result(Call(what, late = {}, action))

    private fun <T> result(call: Call<T>): T {
        val patience = if (unanswered.isEmpty()) limit else minOf(limit, IMPATIENT)
        execute(call)
        return try {
            await(call, patience)
        } catch (e: ExecutionException) {
            throw e.cause ?: e
        } catch (_: TimeoutException) {
            call.giveUp()
            throw NoAnswerException(call.what, patience)
        }
    }

    /** Runs [call] on a thread of its own. */
    protected open fun execute(call: Runnable): Unit = THREADS.execute(call)

    /** Returns the result of [call], or throws TimeoutException after [patience]. */
    protected open fun <T> await(call: Future<T>, patience: Duration): T =
        call.get(patience.inWholeMilliseconds, TimeUnit.MILLISECONDS)

    private inner class Call<T>(val what: String, private val late: (T) -> Unit, action: () -> T) :
        FutureTask<T>(action) {
        /** True from when the caller gave up to when the result came. */
        private val isLate = AtomicBoolean()

        fun giveUp() {
            unanswered.merge(what, 1, Int::plus)
            isLate.set(true)
            if (isDone) answerLate()
        }

        override fun done(): Unit = answerLate()

        private fun answerLate() {
            if (!isLate.compareAndSet(true, false)) return
            unanswered.compute(what) { _, count -> if (count == null || count == 1) null else count - 1 }
            try {
                late(get())
            } catch (_: ExecutionException) {
                // There is nothing to undo, and the caller was told
            } catch (_: Exception) {
                // Undoing failed, after the caller was told; an exception that leaves this thread would end the app
            }
        }
    }

    private companion object {
        val LIMIT = 2.seconds
        val IMPATIENT = 100.milliseconds
        const val IDLE_SECONDS = 5L

        /** As many as calls are made at a time, which are few but for those that are not answered. */
        val THREADS = ThreadPoolExecutor(0, Int.MAX_VALUE, IDLE_SECONDS, TimeUnit.SECONDS, SynchronousQueue()) {
            Thread(it, "ml2s call").apply { isDaemon = true }
        }
    }
}
