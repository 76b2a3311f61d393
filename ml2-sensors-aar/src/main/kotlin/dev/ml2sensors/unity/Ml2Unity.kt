package dev.ml2sensors.unity

import android.content.Context
import android.util.Log
import dev.ml2sensors.android.AndroidKeys
import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.android.missingPermissions
import dev.ml2sensors.android.nsdBrowser
import dev.ml2sensors.capture.LocalFrames
import dev.ml2sensors.capture.NativeLibrary
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.ExperimentalCoroutinesApi
import kotlinx.coroutines.Job
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.cancel
import kotlinx.coroutines.channels.BufferOverflow
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withTimeoutOrNull
import kotlinx.serialization.json.Json
import java.io.IOException
import java.util.concurrent.CountDownLatch
import java.util.concurrent.TimeUnit
import kotlin.concurrent.thread
import kotlin.time.Duration.Companion.milliseconds

/**
 * The headset for the Unity package: numbers, texts and JSON, no Kotlin types. C# leases frames from the native
 * library, see [view].
 *
 * Thread-safe. Only [close] and [permissionsNeeded] block, for at most 0.5 s, whatever the headset does. No lock is
 * held while anything is awaited, and the listener is called by a coroutine of its own. Misuse throws
 * IllegalArgumentException or IllegalStateException.
 */
@OptIn(ExperimentalCoroutinesApi::class) // isEmpty
internal class Ml2Unity private constructor(private val app: Context, private val listener: Ml2UnityListener) {
    private val headset = Ml2Sensors.open(app)
    private val scope = CoroutineScope(SupervisorJob() + Dispatchers.Default)
    private var run: UnityRun? = null

    /** The run of the last start, whose status is told while it ends and afterwards, too. */
    private var lastRun: UnityRun? = null

    /** Held by one run at a time, until it has ended. */
    private val running = Mutex()
    private var ending: Job? = null
    private var isClosed = false
    private var beforeAnyRun = UnityStatus("ended", receiver = "", reason = "not started")
    private val pairing = UnityPairing(app)
    private val inboxes = UnityInboxes(scope)
    private val publishers = UnityPublishers()
    private val services = UnityServices(scope)
    private val calls = PlatformCalls(BLOCKING_LIMIT)

    /** One for all starts, since nothing ends the threads of its managers. */
    private val browser = nsdBrowser(app)

    /** The statuses that the listener has not been told yet. */
    private val changes = Channel<String>(MOST_CHANGES, BufferOverflow.DROP_OLDEST)
    private val notifying = scope.launch(Dispatchers.IO) {
        for (change in changes) {
            listener.changed(change)
            // Two threads may have told theirs in the wrong order
            if (changes.isEmpty) status().let { if (it != change) listener.changed(it) }
        }
    }

    init {
        scope.launch {
            try {
                pairing.load()
            } catch (e: IOException) {
                val reason = e.message ?: e.javaClass.simpleName
                synchronized(this@Ml2Unity) { beforeAnyRun = beforeAnyRun.copy(reason = reason) }
            }
            changed()
        }
    }

    /**
     * Pairs with the receiver that shows [uri], the text or QR code of `ml2-receiver pair`; `pairing` of [status] has
     * the result. Has no effect while another pairing runs. After success, an encrypted stream is started again.
     */
    @Synchronized
    fun pair(uri: String) {
        check(!isClosed) { "this Ml2Unity is closed; call open again" }
        if (!pairing.begin()) return
        scope.launch {
            changed()
            if (pairing.run(uri)) restart()
            changed()
        }
    }

    /**
     * Streams to [receiver] instead of to the previous one; also called again after a permission was granted. If this
     * headset is not paired, [status] has that as the reason.
     *
     * @param receiver a name, `HOST:PORT`, or empty for the paired receiver.
     * @param defaultsJson `{stream id: {value: ...}}`, the streams that run on the headset while no receiver answers;
     * empty values mean the stream's defaults.
     * @param insecure true for connections without encryption or authentication, which the receiver must allow, too.
     * Eye images are refused, and an empty [receiver] means the only one on the network.
     */
    fun start(receiver: String, defaultsJson: String, insecure: Boolean) {
        val next = runOf(UnityRun.Request(receiver, json.decodeFromString(defaultsJson.ifEmpty { "{}" }), insecure))
        check(begin(next)) { "this Ml2Unity is closed; call open again" }
        if (insecure) Log.w(TAG, "insecure: nothing is encrypted, and any machine can impersonate the receiver")
    }

    private fun restart() {
        val request = synchronized(this) { run }?.request?.takeUnless { it.isInsecure } ?: return
        begin(runOf(request))
    }

    private fun runOf(request: UnityRun.Request): UnityRun {
        val keys = AndroidKeys.of(app)
        val isPairedOne = request.receiver.isEmpty() && !request.isInsecure
        val receiver = if (isPairedOne) keys.receiver(browser) else Receiver.parse(request.receiver, browser)
        val security = if (request.isInsecure) TransportSecurity.Insecure() else keys.security()
        return UnityRun(headset, receiver, security, request)
    }

    /** Runs [next] instead of the present run; returns false if this is closed. */
    @Synchronized
    private fun begin(next: UnityRun): Boolean {
        if (isClosed) return false
        stop()
        run = next
        lastRun = next
        inboxes.use(next)
        publishers.use(next.streamer)
        services.use(next.streamer)
        scope.launch { running.withLock { next.run { changed() } } }
        return true
    }

    /** Ends streams and session in order, without waiting for it. */
    @Synchronized
    fun stop() {
        val ended = run ?: return
        run = null
        // Undispatched, so that the run is told even if this is closed before a thread is free
        ending = scope.launch(start = CoroutineStart.UNDISPATCHED) {
            ended.stop()
            changed()
        }
    }

    /** Stops, and closes the headset for good. What takes longer than 0.5 s goes on on another thread. */
    fun close() {
        val ended = synchronized(this) {
            if (isClosed) return
            isClosed = true
            stop()
            ending
        }
        val closed = CountDownLatch(1)
        thread(isDaemon = true, name = "ml2s close") {
            runBlocking {
                withTimeoutOrNull(ENDING_LIMIT) {
                    ended?.join()
                    changes.close()
                    notifying.join()
                }
            }
            headset.close()
            inboxes.close()
            publishers.close()
            services.close()
            scope.cancel()
            pairing.close()
            closed.countDown()
        }
        closed.await(BLOCKING_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS)
    }

    /** Releases all sensors while the app is in the background; the session stays. */
    fun pause() {
        headset.pause()
        changed()
    }

    /** Opens them again after [pause]; a stream whose sensor cannot be opened waits until it can. */
    fun resume() {
        headset.resume()
        changed()
    }

    /**
     * `{"state": "connecting"|"connected"|"ended", "receiver", "reason", "insecure", "streams": {id: {"state":
     * "running"|"waiting"|"refused"|"failed", "reason", "values", "permission"}}, "channels": {topic: {"produced",
     * "sent", "dropped": {reason: count}}}, "clock", "pairing": {"number", "state": "none"|"running"|"paired"|"failed",
     * "reason", "receivers": [{"name", "fingerprint", "address"}]}}`. A stream that is `waiting` is opened again until
     * it runs. Channels and clock are as in STATUS of PROTOCOL.md; the number is how
     * many pairings were tried since [open]; the receiver that was paired last is the last of them.
     */
    fun status(): String {
        val status = synchronized(this) { lastRun }?.status() ?: synchronized(this) { beforeAnyRun }
        return json.encodeToString(status.copy(pairing = pairing.status))
    }

    /**
     * Returns `[{"permission", "reason", "streams": [id]}]`: the permissions that requested streams still need, none
     * while Android does not answer.
     */
    fun permissionsNeeded(): String {
        val wanted = synchronized(this) { run }?.wanted.orEmpty()
        val needing = try {
            wanted.flatMap { stream -> app.missingPermissions(stream, calls).map { it to stream.id } }
        } catch (_: NoAnswerException) {
            emptyList()
        }
        return json.encodeToString(NeededPermission.of(needing))
    }

    /**
     * Enables or disables publishing of a running stream's frames into slots of the native library, for
     * `ml2s_acquire_latest`. Costs nothing while disabled. JPEGs of Android's cameras are copied once, other frames are
     * not copied.
     */
    fun view(streamId: String, on: Boolean): Unit =
        LocalFrames.view(requireNotNull(StreamTable.byId(streamId)) { "there is no stream '$streamId'" }, on)

    /** Returns the topics that the app publishes, which exist as long as this object. */
    fun publishers(): UnityPublishers = publishers

    /** Returns the app's subscriptions, which exist as long as this object. */
    fun inboxes(): UnityInboxes = inboxes

    /** Returns the services that the app calls and offers, which exist as long as this object. */
    fun services(): UnityServices = services

    /** Has the listener called. */
    private fun changed() {
        changes.trySend(status())
    }

    companion object {
        private val json = Json {
            encodeDefaults = true
            explicitNulls = false
        }

        /** The longest wait of Unity's main thread for one call, so that a busy device blocks it for 0.5 s at most. */
        private val BLOCKING_LIMIT = 100.milliseconds

        /** The longest time that [close] gives the session to end in order, before it closes the headset. */
        private val ENDING_LIMIT = 300.milliseconds

        /** More than come while a listener is busy; older ones are left out. */
        private const val MOST_CHANGES = 64
        private const val TAG = "ML2 Sensors"

        /** Opens the headset; nothing runs before [start]. [context] is any of the app's. */
        @JvmStatic
        fun open(context: Context, listener: Ml2UnityListener): Ml2Unity =
            Ml2Unity(context.applicationContext, listener)

        /**
         * Loads libml2sensors.so, for a caller that has no class of the app.
         *
         * @throws UnsatisfiedLinkError if it is not there.
         */
        @JvmStatic
        fun loadLibrary(): Unit = NativeLibrary.load()
    }
}
