package dev.ml2sensors.stream

import dev.ml2sensors.session.Lane
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.switchesOn
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.table.TopicSpec
import dev.ml2sensors.wire.Status
import java.util.concurrent.ConcurrentHashMap

/**
 * The channels and lanes of one app instance, made when first needed and kept with their books over all its sessions.
 * Safe for use by several threads.
 *
 * @param suspendsWhenFull whether full lanes suspend their producers; see [Lane].
 */
internal class TopicChannels(private val suspendsWhenFull: Boolean) {
    private val lanes = ConcurrentHashMap<String, Lane>()
    private val byTopic = ConcurrentHashMap<String, TopicChannel>()

    /** The channels of the topics that [values] switch on, in the order of the table. */
    fun of(spec: StreamSpec, values: StreamValues): List<TopicChannel> =
        spec.topics.filter { values.switchesOn(it.condition) }.map { topic ->
            byTopic.computeIfAbsent(topic.name) {
                TopicChannel(ALL_TOPICS.indexOf(topic) + 1, topic, lane(topic.lane))
            }
        }

    /** The channel of the topic that the app has named as its number [index], from 0. */
    fun custom(topic: TopicSpec, index: Int): TopicChannel = byTopic.computeIfAbsent(topic.name) {
        TopicChannel(ALL_TOPICS.size + 1 + index, topic, lane(topic.lane))
    }

    fun lane(name: String): Lane = lanes.computeIfAbsent(name) {
        Lane(it, if (it == SENSORS) StreamTable.sensorsLane else StreamTable.imageLane, suspendsWhenFull)
    }

    /** Between two sessions: the peer has [received] so many messages per topic, none of those absent. */
    fun reconcile(received: Map<String, Long>) {
        byTopic.forEach { (topic, channel) -> channel.counters.reconcile(received[topic] ?: 0) }
    }

    /** The books by topic. */
    fun counts(): Map<String, Status.ChannelCounts> = byTopic.mapValues { (_, it) -> it.counters.snapshot() }

    private companion object {
        const val SENSORS = "sensors"
        val ALL_TOPICS = StreamTable.all.flatMap { it.topics }
    }
}
