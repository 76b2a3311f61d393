package dev.ml2sensors.unity

import dev.ml2sensors.capture.LocalOutbox
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.TopicPublisher
import dev.ml2sensors.table.StreamTable
import kotlin.concurrent.thread

/**
 * The topics that a Unity app publishes, over starts and stops. C# puts messages into outboxes of the native library by
 * `ml2s_inbox_take` and `ml2s_inbox_add`; a thread for each sends them. Thread-safe.
 */
internal class UnityPublishers {
    private data class Kind(val type: String, val isLatched: Boolean, val isLarge: Boolean, val isStamped: Boolean)

    private class Topic(val name: String, val kind: Kind, depth: Int) {
        val outbox = LocalOutbox(depth)

        @Volatile
        var publisher: TopicPublisher? = null

        fun publish(message: LocalOutbox.Message) {
            val publisher = publisher ?: return
            publisher.lose(message.lost)
            publisher.publish(message.bytes, message.nanos, kind.isStamped)
        }
    }

    private val topics = ArrayList<Topic>()
    private var streamer: Ml2Streamer? = null

    /**
     * Opens a topic of the app's own: `custom/NAME`, or an absolute name. It exists as long as this object. Opening it
     * again gives the same outbox.
     *
     * @param isLatched keeps the newest message for late subscribers.
     * @param isLarge lets messages have up to 16 MiB instead of 64 KiB, all of a message included.
     * @param isStamped says that messages begin with a header, whose stamp is written here.
     * @param depth the messages that wait to be sent; the newest ones stay.
     * @return the number of the outbox.
     * @throws IllegalArgumentException if ROS does not allow the name or type, or the topic was opened otherwise.
     * @throws IllegalStateException if there are too many topics.
     */
    @Synchronized
    fun open(topic: String, type: String, isLatched: Boolean, isLarge: Boolean, isStamped: Boolean, depth: Int): Int {
        val name = topic.removePrefix("${StreamTable.custom.id}/")
        val kind = Kind(type, isLatched, isLarge, isStamped)
        topics.firstOrNull { it.name == name }?.let {
            require(it.kind == kind) { "$topic: expected ${it.kind} as before, found $kind" }
            return it.outbox.number
        }
        StreamTable.customTopics.topic(name, type, known = topics.size)
        val opened = Topic(name, kind, depth)
        topics += opened
        streamer?.let { use(opened, it) }
        thread(isDaemon = true, name = "ml2s $name") { opened.outbox.forEach(opened::publish) }
        return opened.outbox.number
    }

    /** Returns why the receiver does not publish the topic; empty if it does. */
    @Synchronized
    fun refusal(outbox: Int): String =
        topics.firstOrNull { it.outbox.number == outbox }?.publisher?.refusal.orEmpty()

    /** Publishes by [next] from now on. */
    @Synchronized
    fun use(next: Ml2Streamer) {
        streamer = next
        topics.forEach { use(it, next) }
    }

    private fun use(topic: Topic, streamer: Ml2Streamer) {
        topic.publisher = with(topic.kind) { streamer.publisher(topic.name, type, isLatched, isLarge) }
    }

    @Synchronized
    fun close() {
        topics.forEach { it.outbox.close() }
        topics.clear()
    }
}
