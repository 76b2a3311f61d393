package dev.ml2sensors.session

import kotlinx.coroutines.CoroutineDispatcher
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.ensureActive
import kotlinx.coroutines.runInterruptible
import java.io.IOException
import java.util.concurrent.Executors

/**
 * Threads for streams and connections, which may block: as many as block at a time, each of which ends after a minute
 * without work. `Dispatchers.IO` wakes up to five threads for one sample, and its 64 are the app's as well.
 */
internal val blockingThreads: CoroutineDispatcher =
    Executors.newCachedThreadPool { Thread(it, "ml2s blocking").apply { isDaemon = true } }.asCoroutineDispatcher()

/**
 * Runs [block], which may block on connections, on one of the [blockingThreads]. Cancelling closes the connection that
 * it waits for; the resulting failure is not reported.
 */
internal suspend fun <T> blockingIo(block: () -> T): T = try {
    runInterruptible(blockingThreads, block)
} catch (e: IOException) {
    currentCoroutineContext().ensureActive()
    throw e
}
