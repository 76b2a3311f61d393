package dev.ml2sensors.session

import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonPrimitive

/** Watches what a device may say when, by PROTOCOL.md; frames come in the order in which each lane carried them. */
internal class ProtocolJudge(private val host: ScriptedHost) {
    private class Channel(
        val topic: String,
        val lane: String,
        var mayCarry: Boolean = false,
        var isLive: Boolean = true,
    ) {
        var lastSequence = -1L
    }

    private val channels = HashMap<Int, Channel>()
    private var byeWritten = false

    /** The bytes of filler that may still come; null when nothing was asked for. */
    private var fillerBytes: Int? = null

    fun topic(channel: Int): String? = channels[channel]?.topic

    /** The receiver says START: what is announced may carry data. */
    fun start() = channels.values.forEach { it.mayCarry = true }

    /** The receiver asks for filler. */
    fun testLink(bytes: Int) {
        fillerBytes = bytes
    }

    fun judge(frame: HostFrame) {
        if (frame.lane == "control" && frame.kind != HostFrame.END && byeWritten) host.breach("after BYE: $frame")
        when (frame.kind) {
            HostFrame.CHANNEL -> announce(frame)
            HostFrame.CHANNEL_END -> end(frame)
            HostFrame.DATA -> carry(frame)
            HostFrame.FILLER -> fill(frame)
            HostFrame.BYE -> byeWritten = true
        }
    }

    private fun announce(frame: HostFrame) {
        fun text(key: String) = frame.json.getValue(key).jsonPrimitive.content
        val id = text("id").toInt()
        val channel = Channel(text("topic"), text("lane"))
        if (channels.values.any { it.isLive && it.topic == channel.topic }) host.breach("announced twice: $frame")
        channels.put(id, channel)?.let {
            if (it.isLive || it.topic != channel.topic) host.breach("id used twice: $frame")
            channel.lastSequence = it.lastSequence
            channel.mayCarry = it.mayCarry // its late messages may still be on their way
        }
    }

    private fun end(frame: HostFrame) {
        val channel = channels[frame.json.getValue("id").jsonPrimitive.int]
        if (channel?.isLive != true) host.breach("not announced: $frame")
        channel?.isLive = false
    }

    private fun carry(frame: HostFrame) {
        val channel = channels[frame.channel] ?: return host.breach("not announced: $frame")
        if (!channel.mayCarry) host.breach("before START: $frame")
        if (channel.lane != frame.lane) host.breach("belongs on ${channel.lane}: $frame")
        if (frame.sequence <=
            channel.lastSequence
        ) {
            host.breach("${frame.sequence} after ${channel.lastSequence}: $frame")
        }
        if (!frame.body.take(4).toByteArray().contentEquals(ENCAPSULATION)) host.breach("no CDR: $frame")
        channel.lastSequence = frame.sequence
    }

    private fun fill(frame: HostFrame) {
        val left = (fillerBytes ?: return host.breach("not asked for: $frame")) - frame.body.size
        if (left < 0 || frame.lane != "link_test") host.breach("more than asked for, or elsewhere: $frame")
        fillerBytes = left.takeIf { frame.body.isNotEmpty() }
    }

    private companion object {
        val ENCAPSULATION = byteArrayOf(0, 1, 0, 0)
    }
}
