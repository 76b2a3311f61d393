package dev.ml2sensors.session

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.channels.ReceiveChannel
import kotlin.time.Duration
import kotlin.time.TimeSource

/**
 * What a session does to the device's streams. Called by one coroutine at a time, but for [channels], [refuse] and
 * [counts].
 */
internal interface StreamControl {
    /** Ids of the streams that can be configured. */
    val capabilities: List<String>

    /** By stream id, the clock its captures were found to be stamped with, as STATUS names it. */
    val timestampBases: Map<String, String>

    /** How hot the device is, as STATUS names it; null where it does not know. */
    val thermal: String?

    /** How long what is still queued after [stopSources] may take to be sent. */
    val drainLimit: Duration

    /** A session began; the peer has [received] so many messages per topic of this instance, null when it cannot know. */
    fun beginSession(received: Map<String, Long>?)

    /** Makes [requested] what is to run, in frames whose ids begin with [framePrefix], and stops all else. */
    suspend fun configure(requested: Map<String, StreamValues>, framePrefix: String): Map<String, Answer>

    /** Channels of what is configured and has not failed, and the lanes they use. */
    suspend fun channels(): List<ChannelBody>

    fun lane(name: String): Lane

    /**
     * Begins what is configured now and does not run yet, as soon as stamps can be made; does not wait for them. Of
     * the channels the receiver knows those with the ids [known].
     */
    suspend fun start(known: Set<Int>)

    /** The receiver does not publish [channel], for a [reason]. */
    fun refuse(channel: Int, reason: String)

    /** Told when [channels] of the lane `sensors` have come to be that nobody configured. */
    val additions: ReceiveChannel<Unit>

    /** How each stream that was asked for stands, by id, as STATUS names it. */
    val streamStates: Map<String, Status.Stream>

    /** Told when [streamStates] has changed. */
    val stateChanges: ReceiveChannel<Unit>

    /** Streams that ended because their source failed for good, as it happens. */
    val failures: ReceiveChannel<SourceFailure>

    /** What a user wants to read, as it happens. */
    val events: EventQueue

    /** Stops all sources; returns when the last message has been offered. */
    suspend fun stopSources()

    /** The books by topic. */
    fun counts(): Map<String, Status.ChannelCounts>
}

/** A source failed, and its [stream] ended. */
internal class SourceFailure(val stream: String, val reason: String) {
    private val at = TimeSource.Monotonic.markNow()

    /** For people who read it later: how long ago it was, empty for what has just happened. */
    fun ago(): String = at.elapsedNow().inWholeSeconds.let { if (it > 0) " $it s ago" else "" }
}
