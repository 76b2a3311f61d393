package dev.ml2sensors.stream

import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.session.ScriptedHost
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.ExperimentalSerializationApi
import kotlinx.serialization.decodeFromByteArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import kotlinx.serialization.json.long
import java.io.Closeable
import kotlin.test.assertEquals

/** A [FakeHeadset] streamed by [Ml2Streamer] to a [ScriptedHost]. */
internal class StreamFixture(
    timeline: Headset.Timeline = Headset.Timeline.LIVE,
    receiveBufferBytes: Int? = null,
) : Closeable {
    val host = ScriptedHost(receiveBufferBytes)
    val headset = FakeHeadset(timeline)
    val streamer = Ml2Streamer(headset, host.address, TransportSecurity.Insecure(allowsEyeImages = true))

    /** Present device time. */
    val now: Long get() = headset.clock.nowNanos()

    /** Starts streaming; the first [session]. */
    fun start(streams: String, held: List<String> = emptyList(), ros: Boolean = false): HostSession {
        streamer.start()
        return session(streams, held, ros)
    }

    /**
     * A session that is started with [streams], the JSON of CONFIGURE; lanes of [held] are not read yet. The receiver
     * serves apps if [ros].
     */
    fun session(streams: String, held: List<String> = emptyList(), ros: Boolean = false): HostSession {
        val session = host.awaitHello()
        held.forEach(session::hold)
        session.welcome(host.received(), ros = ros)
        session.configure(1, streams)
        session.start(1)
        return session
    }

    /** Stops in order, and asserts that the final STATUS and all memory is settled; gives the counters by topic. */
    fun finish(session: HostSession): Map<String, Counters> = runBlocking {
        streamer.stop("test over")
        session.await(HostFrame.BYE)
        session.awaitEnds()
        val status = session.frames(HostFrame.STATUS).last().json
        assertEquals("true", status.getValue("final").jsonPrimitive.content)
        assertEquals(0, headset.pool.outstanding, "image memory is given back")
        status.getValue("channels").jsonObject.mapValues { (_, counts) ->
            val dropped = counts.jsonObject.getValue("dropped").jsonObject.mapValues { it.value.jsonPrimitive.long }
            fun count(key: String) = counts.jsonObject.getValue(key).jsonPrimitive.long
            Counters(count("produced"), count("sent"), dropped)
        }
    }

    override fun close() {
        runBlocking { streamer.stop() }
        host.close()
    }
}

/** The counters of a channel in STATUS. */
internal data class Counters(val produced: Long, val sent: Long, val dropped: Map<String, Long>)

@OptIn(ExperimentalSerializationApi::class)
internal inline fun <reified T> HostFrame.message(): T = Cdr.decodeFromByteArray(body)

internal object CameraFixtures {
    fun pinhole(width: Int, height: Int) =
        Intrinsics(width, height, 100.0, 110.0, 32.5, 16.25, Distortion.PlumbBob(0.1, -0.2, 0.001, -0.002, 0.05))
}
