package dev.ml2sensors.session

import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.ChannelEnd
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.Start
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock

/** Announces channels to the receiver of a session; PROTOCOL.md, Streams. Safe for use by several coroutines. */
internal class ChannelAnnouncer(private val streams: StreamControl, private val control: ControlLane) {
    private val announcing = Mutex()
    private val announced = HashSet<Int>()

    /** The ids of all CHANNELs sent, in order. */
    private val written = ArrayList<Int>()
    private var writtenBeforeAnswer = 0
    private var openRequest: Long? = null

    /** Announces the channels of [request] and ends all others, before CONFIGURED. */
    suspend fun announceConfigured(request: Long): Unit = announcing.withLock {
        val channels = streams.channels()
        endAllBut(channels)
        announce(channels)
        writtenBeforeAnswer = written.size
        openRequest = request
    }

    /** Announces those of the app's [channels] that it has added, whose lanes are joined. */
    suspend fun announceAdditions(channels: List<ChannelBody>): Unit = announcing.withLock {
        if (openRequest != null) announce(channels)
    }

    /** Ends channels that no longer exist. */
    suspend fun endRemoved(): Unit = announcing.withLock { endAllBut(streams.channels()) }

    /** Returns the ids that the receiver knew when it sent [start], which must answer the last request. */
    suspend fun knownAt(start: Start): Set<Int> = announcing.withLock {
        if (start.request != openRequest) {
            val message = "expected START of request $openRequest, found ${start.request}"
            throw ProtocolException(ErrorCode.UNEXPECTED, message)
        }
        written.take(start.channels ?: writtenBeforeAnswer).toSet()
    }

    private suspend fun announce(channels: List<ChannelBody>) {
        for (channel in channels.filter { announced.add(it.id) }) {
            control.write(FrameKind.CHANNEL, channel)
            written += channel.id
        }
    }

    private suspend fun endAllBut(channels: List<ChannelBody>) {
        val ended = announced - channels.map { it.id }.toSet()
        ended.forEach { control.write(FrameKind.CHANNEL_END, ChannelEnd(it)) }
        announced -= ended
    }
}
