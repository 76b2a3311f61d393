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
 * A sensor of the native library as a source of samples. One thread of its own opens it when the first flow is
 * collected and closes it when the last one has ended; a flow returns after that. A collector that is too slow loses
 * samples, which are counted, and holds up neither the sensor nor other collectors. Flows fail with
 * [CaptureException].
 *
 * A process has one of each sensor and backend at work. All methods may be called from any thread.
 */
public sealed class NativeSource(
    private val sensorCode: Int,
    private val sensorBackend: NativeBackend,
    override val streams: Set<StreamSpec>,
    sensorName: String,
    private val queuedSamples: Int,
) : SensorSource {
    private val thread = SensorThread("ml2s ${sensorName.lowercase()} ${sensorBackend.id}", ::open)

    override val backend: String get() = sensorBackend.id

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        require(stream in streams) { "$stream is not of this source" }
        return try {
            Native.check(sensorCode, sensorBackend.code)
            stream.answer(requested)
        } catch (e: CaptureException.NotAvailable) {
            Answer.Refused(checkNotNull(e.message))
        }
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        require(stream in streams) { "$stream is not of this source" }
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

    /** Gives the sensor back to the device while the app is not in front, at once; flows go on and deliver nothing. */
    public fun pause(): Unit = thread.pause(true)

    /** Takes the sensor again; if that fails, it is the flows that fail. */
    public fun resume(): Unit = thread.pause(false)

    override fun close(): Unit = thread.close()

    /** Throws [CaptureException.InUse] when [subscription] cannot run beside [others]. */
    private fun admit(subscription: Subscription, others: List<Subscription>) {
        for (other in others) {
            val reason = conflict(subscription, other) ?: continue
            throw CaptureException.InUse("${subscription.stream} with ${subscription.values}: $reason")
        }
    }

    /** Why [subscription] cannot run beside [other], null when it can. */
    internal abstract fun conflict(subscription: Subscription, other: Subscription): String?

    internal abstract fun open(subscriptions: List<Subscription>): OpenSensor
}
