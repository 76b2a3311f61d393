package dev.ml2sensors.ros

import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.cdr.layout
import dev.ml2sensors.message.rosType
import dev.ml2sensors.session.AppOpenings
import dev.ml2sensors.session.OpeningLanes
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.KSerializer
import java.nio.ByteBuffer

/** The subscriptions and transforms of an app, over all sessions of its streamer. Thread-safe. */
internal class Subscriptions : AppOpenings {
    private val wanted = LinkedHashSet<Subscription>()

    /** By the ids of the present session, until CLOSE is sent. */
    private val open = HashMap<Int, Subscription>()
    private val changes = Channel<Unit>(Channel.CONFLATED)
    private var isOver = false

    @OptIn(ExperimentalSerializationApi::class)
    fun <T> subscribe(
        topic: String,
        serializer: KSerializer<T>,
        keep: Keep,
        maxHz: Double? = null,
        hash: String? = null,
    ): Flow<Received<T>> {
        val wanted = WantedTopic(topic, serializer.rosType, serializer.descriptor.layout(), keep, maxHz, hash)
        return messages(wanted) { Cdr.decode(serializer, it, allowsTail = true) }
    }

    fun subscribe(
        topic: String,
        type: String,
        keep: Keep,
        maxHz: Double? = null,
        hash: String? = null,
    ): Flow<Received<ByteBuffer>> = messages(WantedTopic(topic, type, layout = null, keep, maxHz, hash)) { it }

    private fun <T> messages(what: WantedTopic, decode: (ByteBuffer) -> T): Flow<Received<T>> =
        frames(what) { frame ->
            val header = frame.header
            val time = header.captureNanos.takeIf { it != 0L }
            Received(decode(ByteBuffer.wrap(frame.body)), time, header.sequence.toUInt().toLong())
        }

    fun transform(frame: String, reference: String, maxHz: Double?): Flow<StampedPose> =
        frames(WantedTransform(frame, reference, maxHz), StampedPose::of)

    private fun <T> frames(what: Wanted, decode: (Frame) -> T): Flow<T> = flow {
        val subscription = Subscription(what)
        begin(subscription)
        try {
            while (true) {
                val frame = subscription.next() ?: break
                val message = try {
                    decode(frame)
                } catch (_: IllegalArgumentException) { // SerializationException is one
                    subscription.countUndecodable()
                    continue
                }
                emit(message)
            }
        } finally {
            leave(subscription)
            subscription.clear()
        }
    }

    @Synchronized
    private fun begin(subscription: Subscription) {
        if (isOver) return subscription.end()
        wanted += subscription
        changes.trySend(Unit)
    }

    @Synchronized
    private fun leave(subscription: Subscription) {
        wanted -= subscription
        changes.trySend(Unit)
    }

    /** Ends all flows, with the streamer. */
    @Synchronized
    fun end() {
        isOver = true
        wanted.forEach { it.end() }
    }

    override suspend fun serve(lanes: OpeningLanes?): Unit = try {
        if (lanes == null) refuseAll() else serveOn(lanes)
    } finally {
        synchronized(this) { open.clear() }
    }

    private suspend fun refuseAll() {
        while (true) {
            synchronized(this) {
                wanted.forEach { it.end(SubscriptionException.notServed(it.what.name)) }
                wanted.clear()
            }
            changes.receive()
        }
    }

    private suspend fun serveOn(lanes: OpeningLanes) {
        while (true) {
            for (id in takeUnwanted()) lanes.close(id)
            for (subscription in unopened()) {
                val id = lanes.nextId()
                synchronized(this) { open[id] = subscription }
                lanes.open(subscription.open(id))
            }
            changes.receive()
        }
    }

    @Synchronized
    private fun takeUnwanted(): List<Int> =
        open.keys.filter { open[it] !in wanted }.also { open.keys.removeAll(it.toSet()) }

    @Synchronized
    private fun unopened(): List<Subscription> = wanted.filter { it !in open.values }

    override fun opened(answer: Opened) {
        if (!answer.isOpen) fail(answer.id, answer.code, answer.reason.orEmpty())
    }

    override fun closed(end: Closed): Unit = fail(end.id, end.code, end.reason)

    @Synchronized
    private fun fail(id: Int, code: String?, why: String) {
        val subscription = open.remove(id) ?: return
        wanted -= subscription
        subscription.end(SubscriptionException.of(subscription.what.name, code, why))
    }

    override fun take(frame: Frame, left: () -> Unit): Boolean {
        val subscription = synchronized(this) { open[frame.header.channel] } ?: return false
        subscription.add(frame, left)
        return true
    }

    @Synchronized
    override fun counts(): Map<String, Status.OpeningCounts> =
        open.filterValues { it.what is WantedTopic }.entries.associate { (id, topic) -> "$id" to topic.counts() }
}

/** One collection of a flow: its queue, which holds what [Keep] says, and its counters. Thread-safe. */
private class Subscription(val what: Wanted) {
    /** [left] is called under the lock, so that messages leave in their order. */
    private class Queued(val frame: Frame, val left: () -> Unit)

    private val depth = (what.keep as? Keep.All)?.depth ?: 1
    private val queue = ArrayDeque<Queued>(depth)
    private val arrivals = Channel<Unit>(Channel.CONFLATED)
    private var expected = 0L
    private var received = 0L
    private var taken = 0L
    private var pushedOut = 0L
    private var undecodable = 0L

    @Synchronized
    fun open(id: Int): Open = what.open(id, expected)

    /** Puts a message into the queue, until [left] is called. */
    fun add(message: Frame, left: () -> Unit) {
        synchronized(this) {
            received++
            expected = (message.header.sequence + 1).toUInt().toLong()
            if (queue.size == depth) {
                queue.removeFirst().left()
                pushedOut++
            }
            queue.addLast(Queued(message, left))
        }
        arrivals.trySend(Unit)
    }

    /** Waits for the oldest message in the queue; returns null at the end, or throws its cause. */
    suspend fun next(): Frame? {
        while (true) {
            poll()?.let { return it }
            val arrival = arrivals.receiveCatching()
            if (arrival.isClosed) {
                arrival.exceptionOrNull()?.let { throw it }
                return null
            }
        }
    }

    @Synchronized
    private fun poll(): Frame? {
        val next = queue.removeFirstOrNull() ?: return null
        taken++
        next.left()
        return next.frame
    }

    /** Lets go of what the app will not take. */
    @Synchronized
    fun clear() {
        queue.forEach { it.left() }
        queue.clear()
    }

    @Synchronized
    fun countUndecodable() {
        taken--
        undecodable++
    }

    /** Ends the flow, because of [cause], after the messages in its queue. */
    fun end(cause: SubscriptionException? = null) {
        arrivals.close(cause)
    }

    @Synchronized
    fun counts(): Status.OpeningCounts {
        val isLatest = what.keep == Keep.Latest
        return Status.OpeningCounts(
            received,
            taken,
            superseded = if (isLatest) pushedOut else 0,
            queueFull = if (isLatest) 0 else pushedOut,
            undecodable,
        )
    }
}
