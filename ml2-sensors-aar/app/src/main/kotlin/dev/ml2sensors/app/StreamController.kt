package dev.ml2sensors.app

import android.content.Context
import dev.ml2sensors.Version
import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.app.robot.RobotArm
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.TEXT_LIMIT
import dev.ml2sensors.app.status.byStream
import dev.ml2sensors.app.thermal.ThermalHeadset
import dev.ml2sensors.app.thermal.batteryCelsius
import dev.ml2sensors.source.Headset
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.StreamerState
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.async
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.StateFlow
import kotlinx.coroutines.flow.asStateFlow
import kotlinx.coroutines.launch
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import java.io.IOException

/**
 * Controls the headset and its one streamer. Thread-safe. Calls are carried out in order, even if the caller no longer
 * waits for them.
 */
internal class StreamController(
    private val context: Context,
    private val settings: AppSettings,
    private val openHeadset: (Context) -> Headset = Ml2Sensors::open,
) {
    private class Run(val streamer: Ml2Streamer, val permissions: Map<String, Boolean>, val watching: Job)

    private val scope = CoroutineScope(SupervisorJob() + Dispatchers.IO.limitedParallelism(1))
    private val mutex = Mutex()
    private val headset by lazy { ThermalHeadset(openHeadset(context)) { settings.pauseWhenHot } }
    private val mutableState = MutableStateFlow<StreamerState?>(null)

    @Volatile
    private var run: Run? = null

    val isOn: Boolean get() = run != null

    /** The sample of a robot's arm; null while it is not shown, or nothing is streamed. */
    @Volatile
    var robot: RobotArm? = null
        private set

    /** The result of the last call, for the user: an error or a success; empty if there is nothing to report. */
    @Volatile
    private var lastResult = ""

    /** The names of the receivers that the headset is paired with. */
    @Volatile
    private var paired = emptyList<String>()

    /** The state of the streamer; null while there is none. */
    val state: StateFlow<StreamerState?> = mutableState.asStateFlow()

    init {
        scope.async { inOrder { readPairings() } } // An error is shown as lastResult
    }

    /**
     * Starts to stream. Reconnects if permissions have changed since the last start, or if the last streamer ended.
     *
     * @throws IllegalStateException if the headset is paired with no receiver.
     * @throws IOException if the file of paired receivers cannot be read.
     */
    suspend fun start(): Unit = inOrder {
        val isAlive = run?.streamer?.state?.value.let { it != null && it !is StreamerState.Ended }
        if (isAlive && run?.permissions == headset.permissions) return@inOrder
        disconnect()
        connect()
    }

    /** Stops streaming. Returns when the session has ended. */
    suspend fun stop(): Unit = inOrder { disconnect() }

    /** Pairs like [Ml2Sensors.pair]. If the headset streams, it continues with the new receiver. */
    suspend fun pair(uri: String): Unit = inOrder {
        val receiver = Ml2Sensors.pair(context, uri)
        readPairings()
        settings.receiver = ""
        reconnect()
        lastResult = "paired with ${receiver.name}"
    }

    /** Changes the receiver, as described at [AppSettings.receiver]. Reconnects if the headset streams. */
    suspend fun setReceiver(receiver: String): Unit = inOrder {
        settings.receiver = receiver
        reconnect()
    }

    /** Shows the sample of a robot's arm or not, as [AppSettings.showRobot] says. Returns at once. */
    fun showRobot() {
        scope.launch { mutex.withLock { updateRobot() } }
    }

    private fun updateRobot() {
        val streamer = run?.streamer?.takeIf { settings.showRobot }
        if ((streamer == null) == (robot == null)) return
        robot?.close()
        robot = streamer?.let { RobotArm(it, scope) }
    }

    fun status(): AppStatus {
        val streamer = run?.streamer?.status(settings.receiver)
        return AppStatus(
            Version.NAME,
            state = streamer?.state ?: "off",
            receiver = streamer?.receiver.orEmpty(),
            reason = streamer?.reason.orEmpty().take(TEXT_LIMIT),
            lastResult = lastResult.take(TEXT_LIMIT),
            paired = paired,
            permissions = headset.permissions,
            clock = streamer?.clock,
            thermal = headset.thermal?.wireName,
            batteryCelsius = batteryCelsius(context),
            startAtBoot = settings.startAtBoot,
            pauseWhenHot = settings.pauseWhenHot,
            streams = streamer?.byStream(headset.paused).orEmpty(),
            robot = robot?.status,
        )
    }

    private suspend fun reconnect() {
        if (run == null) return
        disconnect()
        connect()
    }

    private fun readPairings() {
        paired = Ml2Sensors.receivers(context).map { it.name }
    }

    private suspend fun connect() {
        readPairings()
        check(paired.isNotEmpty()) { "this headset is paired with no receiver; run ml2-receiver pair" }
        val streamer = Ml2Sensors.connect(context, headset, settings.receiver)
        run = Run(streamer, headset.permissions, scope.launch { streamer.state.collect { mutableState.value = it } })
        updateRobot()
        streamer.start()
    }

    private suspend fun disconnect() {
        val ended = run ?: return
        run = null
        updateRobot()
        ended.streamer.stop()
        ended.watching.cancelAndJoin()
        mutableState.value = null
    }

    private suspend fun <T> inOrder(block: suspend () -> T): T = scope.async {
        mutex.withLock {
            try {
                lastResult = ""
                block()
            } catch (e: Exception) {
                lastResult = e.message ?: e.javaClass.simpleName
                throw e
            }
        }
    }.await()
}
