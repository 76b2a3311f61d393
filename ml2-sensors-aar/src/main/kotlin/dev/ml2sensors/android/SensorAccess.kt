package dev.ml2sensors.android

import dev.ml2sensors.capture.SampleQueue
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.CompletableJob
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.filterNotNull
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.flow

/** Lets a source use its sensors except while it is paused, and until it is closed. Thread-safe. */
internal class SensorAccess(private val calls: PlatformCalls = PlatformCalls()) : AutoCloseable {
    /** Completes when the present use has to end; null while paused, and complete for good once closed. */
    private val present = MutableStateFlow<CompletableJob?>(Job())

    /** Runs [block], which returns when its `ending` has completed, each time that the source is not paused. */
    suspend fun use(block: suspend (ending: Job) -> Unit) {
        while (true) {
            val ending = present.filterNotNull().first()
            if (ending.isCompleted) return
            block(ending)
        }
    }

    /**
     * Returns the samples that a platform callback puts into a queue, while the flow is collected.
     *
     * @param what names the sensor.
     * @param register registers the callback, and returns what unregisters it. Neither may ever return.
     * @throws dev.ml2sensors.source.NoAnswerException when the platform has not answered.
     */
    fun callbackSamples(what: String, register: (SampleQueue) -> AutoCloseable): Flow<Sample> = flow {
        use { ending ->
            val queue = SampleQueue(QUEUED_READINGS)
            val call = "Android's registration of $what"
            val registration =
                ofAndroid("$call failed") { calls.call(call, late = AutoCloseable::close) { register(queue) } }
            val closing = ending.invokeOnCompletion { queue.close(cause = null) }
            try {
                queue.deliverTo(this)
            } finally {
                closing.dispose()
                calls.end(call) { registration.close() }
            }
        }
    }

    @Synchronized
    fun pause() {
        val ending = present.value?.takeUnless { it.isCompleted } ?: return
        present.value = null
        ending.complete()
    }

    @Synchronized
    fun resume() {
        if (present.value == null) present.value = Job()
    }

    @Synchronized
    override fun close() {
        val last = present.value ?: Job()
        last.complete()
        present.value = last
    }

    private companion object {
        /** More than one second of the fastest sensor. */
        const val QUEUED_READINGS = 256
    }
}
