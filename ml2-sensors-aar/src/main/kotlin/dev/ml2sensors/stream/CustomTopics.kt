package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.source.Answer
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.channels.Channel

/**
 * Returns why a receiver with this answer accepts no topics from the app, or null if it does. A null answer means that
 * it did not request them.
 */
internal fun Answer?.customRefusal(): String? = when (this) {
    null -> "the receiver accepts no topics from apps: custom.enabled is false in its configuration; set it to true"
    is Answer.Refused -> reason
    else -> null
}

/** The topics that the app defines, and which of them the receiver accepts at present. Thread-safe. */
internal class CustomTopics(private val outgoing: TopicChannels, private val stamps: StampMap) {
    private val publishers = LinkedHashMap<String, TopicPublisher>()
    private var servesApps = true

    /** The reason why the receiver accepts none of them; null if it does, and before its first CONFIGURE. */
    @get:Synchronized
    var refusal: String? = null
        @Synchronized set(value) {
            field = value
            publishers.values.forEach { it.allRefusal = value }
        }

    /** Receives an element when a topic was added. */
    val additions: Channel<Unit> = Channel(Channel.CONFLATED)

    /** The number of the present session. */
    var session: Int = 0
        @Synchronized get
        private set

    /** As [Ml2Streamer.publisher]. */
    @Synchronized
    fun publisher(name: String, type: String, isLatched: Boolean, isLarge: Boolean, will: Will?): TopicPublisher {
        publishers[name]?.let {
            require(it.type == type) { "${it.topic} is ${it.type}, not $type" }
            require(it.isLatched == isLatched && it.isLarge == isLarge && it.channel.will == will) {
                "${it.topic} was made with another isLatched, isLarge or will"
            }
            return it
        }
        val spec = StreamTable.customTopics.topic(name, type, publishers.size, isLatched, isLarge)
        val publisher = TopicPublisher(outgoing.custom(spec, publishers.size, will), stamps)
        publisher.reset(servesApps)
        publisher.allRefusal = refusal
        publishers[name] = publisher
        additions.trySend(Unit)
        return publisher
    }

    @Synchronized
    fun channels(): List<TopicChannel> =
        publishers.values.filter { servesApps || it.isPlain }.map { it.channel }

    /** Starts a session: its receiver does not know any topic yet, and knows plain ones alone unless it [servesApps]. */
    @Synchronized
    fun beginSession(servesApps: Boolean) {
        session++
        refusal = null
        this.servesApps = servesApps
        publishers.values.forEach { it.reset(servesApps) }
    }

    /** Opens the channels [ids], unless that [session] is over. */
    @Synchronized
    fun open(session: Int, ids: Set<Int>) {
        if (session == this.session) publishers.values.filter { it.channel.id in ids }.forEach { it.open() }
    }

    @Synchronized
    fun refuse(channel: Int, reason: String) {
        publishers.values.firstOrNull { it.channel.id == channel }?.refuse(reason)
    }

    /** Closes all topics until they are opened again. */
    @Synchronized
    fun close(): Unit = publishers.values.forEach { it.reset(servesApps) }

    /** Closes all topics. An [open] that is under way in the present session opens none. */
    @Synchronized
    fun endSession() {
        session++
        close()
    }
}
