package dev.ml2sensors.stream

import dev.ml2sensors.session.EventQueue
import dev.ml2sensors.session.SourceFailure
import dev.ml2sensors.session.StreamReports
import dev.ml2sensors.source.Headset
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.ReceiveChannel

/** The [StreamReports] of [ActiveStreams]. */
internal class DeviceReports(
    private val headset: Headset,
    private val outgoing: TopicChannels,
    private val streams: StreamStates,
    private val adaptation: ImageAdaptation,
    override val events: EventQueue,
    private val latest: Conditions,
) : StreamReports {
    override val streamStates: Map<String, Status.Stream> get() = streams.toBodies(adaptation::lowered)

    override val stateChanges: ReceiveChannel<Unit> get() = streams.changes

    override val failures: Channel<SourceFailure> = Channel(MOST_FAILURES, BufferOverflow.DROP_OLDEST)

    override val timestampBases: Map<String, String>
        get() = headset.timestampBases.mapValues { (_, base) -> base.wireName }

    override val thermal: String? get() = headset.thermal?.wireName

    override val conditions: Map<String, Status.Condition> get() = latest.toBodies()

    override fun counts(): Map<String, Status.ChannelCounts> = outgoing.counts()

    private companion object {
        /** More than the number of streams: each fails once until it is requested again. */
        const val MOST_FAILURES = 64
    }
}
