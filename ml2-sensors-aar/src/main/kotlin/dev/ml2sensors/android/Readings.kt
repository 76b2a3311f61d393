package dev.ml2sensors.android

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import kotlinx.coroutines.Job
import kotlinx.coroutines.channels.SendChannel
import kotlinx.coroutines.channels.awaitClose
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.buffer
import kotlinx.coroutines.flow.callbackFlow

/** Hands the readings of one sensor from the thread they arrive on to a collector, without ever waiting for it. */
internal class Readings(private val queue: SendChannel<Sample>) {
    private val losses = Losses()

    /** When the queue is full the reading is lost, which is told before the next that finds room. */
    fun offer(reading: Sample) {
        losses.tell(reading.captureNanos) { queue.trySend(it).isSuccess }
        if (queue.trySend(reading).isFailure) lose()
    }

    fun lose(): Unit = losses.add(DropReason.SOURCE_LATE)

    fun fail(cause: SourceException) {
        queue.close(cause)
    }
}

/**
 * What a platform's callback delivers while it is collected, and until [closed].
 *
 * @param register starts the callback and answers with what stops it.
 */
internal fun readings(closed: Job, register: (Readings) -> AutoCloseable): Flow<Sample> =
    callbackFlow {
        if (closed.isCompleted) {
            channel.close()
            return@callbackFlow
        }
        val registration = register(Readings(channel))
        val closing = closed.invokeOnCompletion { channel.close() }
        awaitClose {
            registration.close()
            closing.dispose()
        }
    }.buffer(QUEUED_READINGS)

/** Over a second of the fastest sensor. */
private const val QUEUED_READINGS = 256
