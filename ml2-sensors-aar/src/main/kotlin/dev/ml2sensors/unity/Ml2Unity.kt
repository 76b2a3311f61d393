package dev.ml2sensors.unity

import android.content.Context
import android.util.Log
import dev.ml2sensors.android.AndroidKeys
import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.android.missingPermissions
import dev.ml2sensors.android.nsdBrowser
import dev.ml2sensors.capture.LocalFrames
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.cancel
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeoutOrNull
import kotlinx.serialization.json.Json
import java.io.IOException
import java.nio.ByteBuffer
import kotlin.time.Duration.Companion.milliseconds

/**
 * The headset as Unity's package sees it: numbers, texts and JSON, no Kotlin types. Frames do not pass here; C# leases
 * them from the native library, see [view].
 *
 * Any thread; nothing waits but [close], for half a second at most. Misuse throws IllegalArgumentException or
 * IllegalStateException.
 */
public class Ml2Unity private constructor(private val app: Context, private val listener: Ml2UnityListener) {
    private class Topic(val name: String, val type: String)

    private val headset = Ml2Sensors.open(app)
    private val scope = CoroutineScope(SupervisorJob() + Dispatchers.Default)
    private val topics = ArrayList<Topic>()
    private var run: UnityRun? = null
    private var ending: Job? = null
    private var isClosed = false
    private var last = UnityStatus("ended", receiver = "", reason = "not started")
    private val pairing = UnityPairing(app)
    private val telling = Any()

    init {
        scope.launch {
            try {
                pairing.load()
            } catch (e: IOException) {
                synchronized(this@Ml2Unity) { last = last.copy(reason = e.message ?: e.javaClass.simpleName) }
            }
            changed()
        }
    }

    /**
     * Pairs with the receiver that shows [uri], text or QR code of `ml2-receiver pair`; `pairing` of [status] says what
     * becomes of it. Without effect while another pairing is under way. What was started, and not as insecure, starts
     * anew when it has succeeded.
     */
    @Synchronized
    public fun pair(uri: String) {
        check(!isClosed) { "it is closed" }
        if (!pairing.begin()) return
        scope.launch {
            changed()
            if (pairing.run(uri)) startAnew()
            changed()
        }
    }

    /**
     * Streams what [receiver] asks for, instead of to the one before; also to ask anew after a permission was granted.
     * That this headset is not paired is a reason in [status].
     *
     * @param receiver a name, `HOST:PORT`, or empty for the one that this headset is paired with.
     * @param defaultsJson `{stream id: {value: ...}}`, what runs on the headset alone as long as no receiver answers;
     * empty values are the stream's default ones.
     * @param insecure encrypts nothing and trusts everybody; the receiver must be told, too. Eye images are refused,
     * and an empty [receiver] is the only one there is.
     */
    @Synchronized
    public fun start(receiver: String, defaultsJson: String, insecure: Boolean) {
        check(!isClosed) { "it is closed" }
        start(UnityRun.Request(receiver, json.decodeFromString(defaultsJson.ifEmpty { "{}" }), insecure))
        if (insecure) Log.w(TAG, "insecure: nothing is encrypted, and anybody can pretend to be the receiver")
    }

    @Synchronized
    private fun startAnew() {
        run?.request?.takeUnless { it.isInsecure }?.let(::start)
    }

    private fun start(request: UnityRun.Request) {
        val browser = nsdBrowser(app)
        val keys = AndroidKeys.of(app)
        val isPairedOne = request.receiver.isEmpty() && !request.isInsecure
        val receiver = if (isPairedOne) keys.receiver(browser) else Receiver.parse(request.receiver, browser)
        val security = if (request.isInsecure) TransportSecurity.Insecure() else keys.security()
        stop()
        val next = UnityRun(headset, receiver, security, request)
        topics.forEach { next.open(it.name, it.type) }
        run = next
        val before = ending
        scope.launch {
            before?.join()
            next.run { changed() }
        }
    }

    /** Ends the streams and the session in order; what it takes goes on by itself. */
    @Synchronized
    public fun stop() {
        val ended = run ?: return
        run = null
        ending = scope.launch {
            ended.stop()
            synchronized(this@Ml2Unity) { last = ended.status() }
            changed()
        }
    }

    /** Stops, and lets go of the headset for good. */
    public fun close() {
        val ended = synchronized(this) {
            if (isClosed) return
            isClosed = true
            stop()
            ending
        }
        runBlocking { withTimeoutOrNull(CLOSE_LIMIT) { ended?.join() } }
        headset.close()
        scope.cancel()
    }

    /** Gives cameras and trackers back to the device while the app is not in front; the session stays. */
    public fun pause(): Unit = headset.pause()

    /** Takes them again after [pause]; where that fails, streams wait until it succeeds. */
    public fun resume(): Unit = headset.resume()

    /**
     * `{"state": "connecting"|"connected"|"ended", "receiver", "reason", "insecure", "streams": {id: {"state":
     * "accepted"|"waiting"|"refused"|"failed", "reason", "values", "permission"}}, "channels": {topic: {"produced",
     * "sent", "dropped": {reason: count}}}, "clock", "pairing": {"number", "state": "none"|"running"|"paired"|"failed",
     * "reason", "receivers": [{"name", "fingerprint", "address"}]}}`. A stream that is `waiting` is opened again until
     * it runs. Channels and clock are as in STATUS of PROTOCOL.md; the number is how
     * many pairings were tried since [open]; the receiver that was paired last is the last of them.
     */
    public fun status(): String {
        val status = synchronized(this) { run?.status() ?: last }
        return json.encodeToString(status.copy(pairing = pairing.status))
    }

    /** `[{"permission", "reason", "streams": [id]}]`: what the user must yet allow for the streams that are wanted. */
    public fun permissionsNeeded(): String {
        val wanted = synchronized(this) { run }?.wanted.orEmpty()
        val needing = wanted.flatMap { stream -> app.missingPermissions(stream).map { it to stream.id } }
        val rows = needing.groupBy({ it.first }, { it.second }).map { (permission, streams) ->
            NeededPermission(permission, "wanted for ${streams.joinToString()}", streams)
        }
        return json.encodeToString(rows)
    }

    /**
     * Whether frames of a stream, while it runs, are published into slots of the native library for
     * `ml2s_acquire_latest`. Costs nothing while off; cameras of Android are copied once, as JPEG, others not at all.
     */
    public fun view(streamId: String, on: Boolean): Unit = LocalFrames.view(stream(streamId), on)

    /**
     * A topic of the app's own, `custom/[topic]`, of a ROS [type]; it lives as long as this, over starts and stops.
     *
     * @return what [publish] takes.
     */
    @Synchronized
    public fun openPublisher(topic: String, type: String): Int {
        val name = topic.removePrefix("${StreamTable.custom.id}/")
        val known = topics.indexOfFirst { it.name == name }
        if (known >= 0) {
            require(topics[known].type == type) { "custom/$name is ${topics[known].type}, not $type" }
            return known
        }
        StreamTable.customTopics.topic(name, type, known = topics.size)
        topics += Topic(name, type)
        run?.open(name, type)
        return topics.lastIndex
    }

    /**
     * Sends a message; [payload] is all of it as CDR, behind `00 01 00 00`.
     *
     * @param captureNanos CLOCK_BOOTTIME, as of `ml2s_now`; not more than a second ahead of it.
     * @return false while no receiver takes it; [refusal] may say why.
     */
    public fun publish(publisher: Int, payload: ByteArray, captureNanos: Long): Boolean =
        synchronized(this) { run }?.publisher(publisher)?.publish(ByteBuffer.wrap(payload), captureNanos) ?: false

    /** Why the receiver does not publish the topic, empty as long as it does. */
    public fun refusal(publisher: Int): String =
        synchronized(this) { run }?.publisher(publisher)?.refusal.orEmpty()

    /** ROS time, ns, of what was captured at [captureNanos], CLOCK_BOOTTIME; 0 while it is not known. */
    public fun stampNanos(captureNanos: Long): Long = synchronized(this) { run }?.stampNanos(captureNanos) ?: 0

    /** Never while this is locked. */
    private fun changed(): Unit = synchronized(telling) { listener.changed(status()) }

    public companion object {
        private val json = Json {
            encodeDefaults = true
            explicitNulls = false
        }
        private val CLOSE_LIMIT = 500.milliseconds
        private const val TAG = "ML2 Sensors"

        /** Opens the headset; nothing runs before [start]. [context] is any of the app's. */
        @JvmStatic
        public fun open(context: Context, listener: Ml2UnityListener): Ml2Unity =
            Ml2Unity(context.applicationContext, listener)

        private fun stream(id: String): StreamSpec =
            requireNotNull(StreamTable.byId(id)) { "there is no stream '$id', only ${StreamTable.all.joinToString()}" }
    }
}
