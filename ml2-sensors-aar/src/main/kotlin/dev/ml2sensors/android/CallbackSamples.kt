package dev.ml2sensors.android

import dev.ml2sensors.capture.SampleQueue
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow

/**
 * Returns the samples that a platform callback puts into a queue, while the flow is collected and until [closed].
 *
 * @param register registers the callback, and returns what unregisters it.
 */
internal fun callbackSamples(closed: Job, register: (SampleQueue) -> AutoCloseable): Flow<Sample> =
    flow {
        if (closed.isCompleted) return@flow
        val queue = SampleQueue(QUEUED_READINGS)
        val registration = register(queue)
        val closing = closed.invokeOnCompletion { queue.close(cause = null) }
        try {
            queue.deliverTo(this)
        } finally {
            closing.dispose()
            registration.close()
        }
    }

/** More than one second of the fastest sensor. */
private const val QUEUED_READINGS = 256
