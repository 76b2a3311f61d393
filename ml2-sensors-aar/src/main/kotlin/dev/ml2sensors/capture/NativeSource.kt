package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.catch
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withContext

/**
 * A sensor of the native library as a source of samples. A thread of its own opens the sensor when the first flow is
 * collected, and closes it after the last one has ended; only then does a flow return. A slow collector loses samples,
 * which are counted, and delays neither the sensor nor other collectors. Flows fail with [CaptureException].
 *
 * Create only one source for each sensor and backend in a process. Thread-safe.
 */
internal sealed class NativeSource(
    private val sensorCode: Int,
    private val sensorBackend: NativeBackend,
    override val streams: Set<StreamSpec>,
    sensorName: String,
    private val queuedSamples: Int,
    isUrgent: Boolean,
) : SensorSource {
    private val thread = SensorThread("ml2s ${sensorName.lowercase()} ${sensorBackend.id}", isUrgent, ::open)

    override val backend: String get() = sensorBackend.id

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        require(stream in streams) { "this source has no stream $stream" }
        return try {
            Native.check(sensorCode, sensorBackend.code)
            stream.answer(requested)
        } catch (e: CaptureException.NotAvailable) {
            Answer.Refused(checkNotNull(e.message))
        }
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        require(stream in streams) { "this source has no stream $stream" }
        return flow {
            val subscription = Subscription(stream, values, SampleQueue(queuedSamples))
            thread.subscribe(subscription) { others -> admit(subscription, others) }
            try {
                subscription.queue.deliverTo(this)
            } finally {
                withContext(NonCancellable) { thread.unsubscribe(subscription) }
            }
        }.catch { throw it.named(stream) }
    }

    private fun Throwable.named(stream: StreamSpec): Throwable =
        if (this !is CaptureException.PermissionDenied) {
            this
        } else {
            CaptureException.PermissionDenied(message.orEmpty(), stream.permissions.firstOrNull())
        }

    override fun pause(): Unit = thread.pause(true)

    override fun resume(): Unit = thread.pause(false)

    override fun close(): Unit = thread.close()

    /** Throws [CaptureException.InUse] when [subscription] cannot run beside [others]. */
    private fun admit(subscription: Subscription, others: List<Subscription>) {
        for (other in others) {
            val reason = conflict(subscription, other) ?: continue
            throw CaptureException.InUse("${subscription.stream} with ${subscription.values}: $reason")
        }
    }

    /** Returns why [subscription] cannot run together with [other], or null if it can. */
    internal abstract fun conflict(subscription: Subscription, other: Subscription): String?

    internal abstract fun open(subscriptions: List<Subscription>): OpenSensor
}
