package dev.ml2sensors.android

import dev.ml2sensors.capture.HandOver
import dev.ml2sensors.source.Sample
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow

/**
 * What a callback of the platform delivers while it is collected, and until [closed].
 *
 * @param register starts the callback and answers with what stops it.
 */
internal fun readings(closed: Job, register: (HandOver) -> AutoCloseable): Flow<Sample> =
    flow {
        if (closed.isCompleted) return@flow
        val handOver = HandOver(QUEUED_READINGS)
        val registration = register(handOver)
        val closing = closed.invokeOnCompletion { handOver.close(cause = null) }
        try {
            handOver.deliverTo(this)
        } finally {
            closing.dispose()
            registration.close()
        }
    }

/** Over a second of the fastest sensor. */
private const val QUEUED_READINGS = 256
