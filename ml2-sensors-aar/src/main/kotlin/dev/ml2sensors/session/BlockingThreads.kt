package dev.ml2sensors.session

import dev.ml2sensors.source.URGENT_PRIORITY
import dev.ml2sensors.source.imagePriority
import kotlinx.coroutines.CoroutineDispatcher
import kotlinx.coroutines.asCoroutineDispatcher
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.ensureActive
import kotlinx.coroutines.runInterruptible
import java.io.IOException
import java.util.concurrent.Executors
import kotlin.coroutines.ContinuationInterceptor

/**
 * Threads for streams and connections, which may block: as many as block at a time, each of which ends after a minute
 * without work. `Dispatchers.IO` wakes up to five threads for one sample, and its 64 are the app's as well.
 */
internal val blockingThreads: CoroutineDispatcher = threads("ml2s blocking", URGENT_PRIORITY)

/** As [blockingThreads], which they give way to: for images, whose pixels are copied, compressed and encrypted. */
internal val imageThreads: CoroutineDispatcher = threads("ml2s images", imagePriority)

private fun threads(name: String, priority: Int) = Executors.newCachedThreadPool {
    Thread(it, name).apply {
        isDaemon = true
        this.priority = priority
    }
}.asCoroutineDispatcher()

/**
 * Runs [block], which may block on connections, on one of the [imageThreads] if called from there, else on one of the
 * [blockingThreads]. Cancelling closes the connection that it waits for; the resulting failure is not reported.
 */
internal suspend fun <T> blockingIo(block: () -> T): T = try {
    val isOfImages = currentCoroutineContext()[ContinuationInterceptor] === imageThreads
    runInterruptible(if (isOfImages) imageThreads else blockingThreads, block)
} catch (e: IOException) {
    currentCoroutineContext().ensureActive()
    throw e
}
