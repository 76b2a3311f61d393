package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.source.Answer
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.channels.Channel

/** Why a receiver that gets this answer, null when it did not ask, takes no topics of the app. */
internal fun Answer?.customRefusal(): String? = when (this) {
    null -> "the receiver takes no topics of apps: custom.enabled is false in its configuration; set it to true"
    is Answer.Refused -> reason
    else -> null
}

/** The topics that the app names itself, and which of them the receiver takes at present. Any thread. */
internal class CustomTopics(private val outgoing: TopicChannels, private val stamps: StampMap) {
    private val publishers = LinkedHashMap<String, TopicPublisher>()

    /** Why the receiver takes none of them; null when it does, and before it has said what it wants. */
    @get:Synchronized
    var refusal: String? = null
        @Synchronized set(value) {
            field = value
            publishers.values.forEach { it.allRefusal = value }
        }

    /** Told of new ones. */
    val additions: Channel<Unit> = Channel(Channel.CONFLATED)

    /** Counts sessions. */
    var link: Int = 0
        @Synchronized get
        private set

    /** As [Ml2Streamer.publisher]. */
    @Synchronized
    fun publisher(name: String, type: String): TopicPublisher {
        publishers[name]?.let {
            require(it.type == type) { "${it.topic} is ${it.type}, not $type" }
            return it
        }
        val spec = StreamTable.customTopics.topic(name, type, known = publishers.size)
        val publisher = TopicPublisher(outgoing.custom(spec, publishers.size), stamps)
        publisher.allRefusal = refusal
        publishers[name] = publisher
        additions.trySend(Unit)
        return publisher
    }

    @Synchronized
    fun channels(): List<TopicChannel> = publishers.values.map { it.channel }

    /** A session began: its receiver has yet to learn of all. */
    @Synchronized
    fun beginSession() {
        link++
        refusal = null
        publishers.values.forEach { it.reset() }
    }

    /** The receiver takes messages of the channels [ids], unless this was before another session than [link]. */
    @Synchronized
    fun open(link: Int, ids: Set<Int>) {
        if (link == this.link) publishers.values.filter { it.channel.id in ids }.forEach { it.open() }
    }

    @Synchronized
    fun refuse(channel: Int, reason: String) {
        publishers.values.firstOrNull { it.channel.id == channel }?.refuse(reason)
    }

    /** Lets them be open until cancelled. */
    suspend fun run() {
        try {
            awaitCancellation()
        } finally {
            close()
        }
    }

    @Synchronized
    private fun close() = publishers.values.forEach { it.reset() }
}
