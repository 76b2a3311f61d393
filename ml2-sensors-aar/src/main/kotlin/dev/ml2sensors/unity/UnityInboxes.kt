package dev.ml2sensors.unity

import dev.ml2sensors.capture.LocalInbox
import dev.ml2sensors.ros.Keep
import dev.ml2sensors.ros.Received
import dev.ml2sensors.ros.SubscriptionException
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.launch
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import java.nio.ByteBuffer

/**
 * The subscriptions of a Unity app, over starts and stops. Their messages wait in the native library, from which C# takes
 * them by `ml2s_inbox_acquire`. Thread-safe.
 */
internal class UnityInboxes(private val scope: CoroutineScope) {
    /** The topics of one run of the streamer. */
    fun interface Topics {
        /** Receives messages of a topic as their CDR until the end of the run. */
        fun messages(topic: String, type: String, keep: Keep, maxHz: Double?, hash: String?): Flow<Received<ByteBuffer>>
    }

    private class Subscription(
        val topic: String,
        val type: String,
        val hash: String?,
        val keep: Keep,
        val maxHz: Double?,
    ) {
        val inbox = LocalInbox((keep as? Keep.All)?.depth ?: 1)
        var job: Job? = null

        /** Held by the messages of one run at a time, until none comes any more. */
        val taking = Mutex()

        @Volatile
        var refusal = ""
    }

    private val subscriptions = HashMap<Int, Subscription>()
    private var run: Topics? = null

    /**
     * Subscribes to a ROS topic.
     *
     * @param hash of the type, or empty.
     * @param depth the messages that wait for a frame of Unity; 1 is the newest alone.
     * @param maxHz the greatest rate at which the receiver sends messages; 0 has no bound.
     * @return the number of the inbox.
     */
    @Synchronized
    fun subscribe(topic: String, type: String, hash: String, depth: Int, maxHz: Double): Int {
        val keep = if (depth == 1) Keep.Latest else Keep.All(depth)
        val subscription = Subscription(topic, type, hash.ifEmpty { null }, keep, maxHz.takeIf { it != 0.0 })
        subscriptions[subscription.inbox.number] = subscription
        run?.let { use(subscription, it) }
        return subscription.inbox.number
    }

    /** Ends a subscription. */
    @Synchronized
    fun unsubscribe(inbox: Int) {
        subscriptions.remove(inbox)?.let {
            it.job?.cancel()
            it.inbox.close()
        }
    }

    /** Returns why the receiver does not send the topic; empty if it does. */
    @Synchronized
    fun refusal(inbox: Int): String = subscriptions[inbox]?.refusal.orEmpty()

    /** Takes messages of [next] from now on. */
    @Synchronized
    fun use(next: Topics) {
        run = next
        subscriptions.values.forEach { use(it, next) }
    }

    private fun use(subscription: Subscription, run: Topics) {
        subscription.job?.cancel()
        subscription.job = scope.launch { subscription.taking.withLock { subscription.take(run) } }
    }

    private suspend fun Subscription.take(run: Topics) {
        refusal = ""
        try {
            run.messages(topic, type, keep, maxHz, hash).collect {
                inbox.add(it.message, it.publishedNanos ?: 0, it.number.toInt())
            }
        } catch (e: SubscriptionException) {
            refusal = e.message.orEmpty()
        } catch (e: IllegalArgumentException) { // The name, type or hash is none
            refusal = e.message.orEmpty()
        }
    }

    @Synchronized
    fun close() {
        subscriptions.keys.toList().forEach(::unsubscribe)
    }
}
