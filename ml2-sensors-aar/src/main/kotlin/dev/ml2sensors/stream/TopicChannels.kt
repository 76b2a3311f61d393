package dev.ml2sensors.stream

import dev.ml2sensors.session.Lane
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.topics
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.table.TopicSpec
import dev.ml2sensors.wire.Status
import java.util.concurrent.ConcurrentHashMap

/**
 * The channels and lanes of one app instance, made when first needed and kept with their counters over all its
 * sessions. Thread-safe.
 *
 * @param suspendsWhenFull true if full lanes suspend their producers; see [Lane].
 */
internal class TopicChannels(private val suspendsWhenFull: Boolean) {
    private val lanes = ConcurrentHashMap<String, Lane>()
    private val byTopic = ConcurrentHashMap<String, TopicChannel>()

    /** Returns the channels of the topics that [values] enable, in the order of the table. */
    fun of(spec: StreamSpec, values: StreamValues): List<TopicChannel> =
        spec.topics(values).map { topic ->
            byTopic.computeIfAbsent(topic.name) {
                TopicChannel(ALL_TOPICS.indexOf(topic) + 1, topic, lane(topic.lane))
            }
        }

    /** Returns the channel of the app's topic number [index], from 0. */
    fun custom(topic: TopicSpec, index: Int, will: Will?): TopicChannel = byTopic.computeIfAbsent(topic.name) {
        TopicChannel(ALL_TOPICS.size + 1 + index, topic, lane(topic.lane), will)
    }

    /** Returns the lane with this name, which has to be one of the table. */
    fun lane(name: String): Lane = lanes.computeIfAbsent(name) {
        Lane(it, LANE_CLASSES.getValue(it), suspendsWhenFull)
    }

    /** Corrects the counters between two sessions by the messages per topic that the peer has [received]. */
    fun reconcile(received: Map<String, Long>) {
        byTopic.forEach { (topic, channel) -> channel.counters.reconcile(received[topic] ?: 0) }
    }

    /** Returns the counters by topic. */
    fun counts(): Map<String, Status.ChannelCounts> = byTopic.mapValues { (_, it) -> it.counters.snapshot() }

    private companion object {
        val ALL_TOPICS = StreamTable.all.flatMap { it.topics }
        val LANE_CLASSES = ALL_TOPICS.associate { it.lane to it.laneClass } +
            StreamTable.customTopics.lanes
    }
}
