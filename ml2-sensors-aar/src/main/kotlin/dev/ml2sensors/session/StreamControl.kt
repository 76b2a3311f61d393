package dev.ml2sensors.session

import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.wire.ChannelBody
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.channels.ReceiveChannel
import kotlin.time.Duration
import kotlin.time.TimeSource

/** A session's control of the device's streams. Called by one coroutine at a time, except [channels] and [refuse]. */
internal interface StreamControl {
    /** Says how the streams fare. */
    val reports: StreamReports

    /** The time limit for sending queued data after [stopSources]. */
    val drainLimit: Duration

    /**
     * Starts a session. [received] is the number of messages per topic that the peer has received from this instance,
     * null if it cannot know. It [servesApps] if it knows more than plain topics of the app.
     */
    fun beginSession(received: Map<String, Long>?, servesApps: Boolean)

    /**
     * Configures the [requested] streams, with frame ids that begin with [framePrefix], and stops all others. Images
     * give way to the link if [adapts].
     */
    suspend fun configure(
        requested: Map<String, StreamValues>,
        framePrefix: String,
        adapts: Boolean,
    ): Map<String, Answer>

    /** Adapts images to what [pacing] knows of the link, if the configuration says so, until it is cancelled. */
    suspend fun adaptTo(pacing: ImagePacing)

    /** Returns the channels of all configured streams that have not failed. */
    suspend fun channels(): List<ChannelBody>

    fun lane(name: String): Lane

    /**
     * Starts the configured streams that do not run yet, as soon as stamps can be made; does not wait for that. The
     * receiver knows the channels [known].
     */
    suspend fun start(known: Set<Int>)

    /** Records that the receiver does not publish [channel], for a [reason]. */
    fun refuse(channel: Int, reason: String)

    /** Receives an element when the app has added [channels]. */
    val additions: ReceiveChannel<Unit>

    /** Stops all sources; returns when the last message has been offered. */
    suspend fun stopSources()
}

/** The reports of a session on the device's streams. Thread-safe. */
internal interface StreamReports {
    /** The clock that stamps each stream's captures, by stream id, as in STATUS. */
    val timestampBases: Map<String, String>

    /** The thermal state as in STATUS, null if unknown. */
    val thermal: String?

    /** The present conditions of what the headset perceives, as in STATUS. */
    val conditions: Map<String, Status.Condition>

    /** The state of each requested stream by id, as in STATUS. */
    val streamStates: Map<String, Status.Stream>

    /** Receives an element when [streamStates] has changed. */
    val stateChanges: ReceiveChannel<Unit>

    /** The streams that ended because their source failed permanently. */
    val failures: ReceiveChannel<SourceFailure>

    /** The events for users. */
    val events: EventQueue

    /** Returns the counters by topic. */
    fun counts(): Map<String, Status.ChannelCounts>
}

/** A source failed, and its [stream] ended. */
internal class SourceFailure(val stream: String, val reason: String) {
    private val at = TimeSource.Monotonic.markNow()

    /** Returns how long ago it was, as text; empty if it has just happened. */
    fun ago(): String = at.elapsedNow().inWholeSeconds.let { if (it > 0) " $it s ago" else "" }
}
