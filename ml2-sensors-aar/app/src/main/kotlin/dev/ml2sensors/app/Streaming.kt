package dev.ml2sensors.app

import android.content.Context
import dev.ml2sensors.Version
import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.app.heat.CooledHeadset
import dev.ml2sensors.app.heat.batteryCelsius
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.TEXT_LIMIT
import dev.ml2sensors.app.status.byStream
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
 * The headset and its one streamer, from start to stop. Any thread; what is asked for is done in that order, also when
 * the caller no longer waits for it.
 */
internal class Streaming(private val context: Context, private val choices: Choices) {
    private class Run(val streamer: Ml2Streamer, val permissions: Map<String, Boolean>, val watching: Job)

    private val scope = CoroutineScope(SupervisorJob() + Dispatchers.IO.limitedParallelism(1))
    private val turns = Mutex()
    private val headset by lazy { CooledHeadset(Ml2Sensors.open(context)) { choices.coolsDown } }
    private val mutableState = MutableStateFlow<StreamerState?>(null)

    @Volatile
    private var run: Run? = null

    val isOn: Boolean get() = run != null

    /** What went wrong last, or well; empty when nothing has. */
    @Volatile
    private var news = ""

    /** The receivers that the headset is paired with, by name. */
    @Volatile
    private var paired = emptyList<String>()

    /** Of the streamer; null while there is none. */
    val state: StateFlow<StreamerState?> = mutableState.asStateFlow()

    init {
        scope.async { inTurn { readPairings() } } // What goes wrong is news
    }

    /**
     * Streams from now on; begins anew where the user has allowed or forbidden something since.
     *
     * @throws IllegalStateException when the headset is paired with no receiver.
     * @throws IOException when what is known of receivers cannot be read.
     */
    suspend fun start(): Unit = inTurn {
        if (run?.permissions == headset.permissions) return@inTurn
        end()
        begin()
    }

    /** Returns when all has ended in order. */
    suspend fun stop(): Unit = inTurn { end() }

    /** As [Ml2Sensors.pair]; whatever streams goes on with the new receiver. */
    suspend fun pair(uri: String): Unit = inTurn {
        val receiver = Ml2Sensors.pair(context, uri)
        readPairings()
        choices.receiver = ""
        beginAnew()
        news = "paired with ${receiver.name}"
    }

    /** From now on to [receiver], as of [Choices.receiver]. */
    suspend fun goTo(receiver: String): Unit = inTurn {
        choices.receiver = receiver
        beginAnew()
    }

    fun status(): AppStatus {
        val streamer = run?.streamer?.status(choices.receiver)
        return AppStatus(
            Version.NAME,
            state = streamer?.state ?: "off",
            receiver = streamer?.receiver.orEmpty(),
            reason = streamer?.reason.orEmpty().take(TEXT_LIMIT),
            news = news.take(TEXT_LIMIT),
            paired = paired,
            permissions = headset.permissions,
            clock = streamer?.clock,
            thermal = headset.thermal?.wireName,
            batteryCelsius = batteryCelsius(context),
            atBoot = choices.atBoot,
            coolsDown = choices.coolsDown,
            streams = streamer?.byStream(headset.resting).orEmpty(),
        )
    }

    private suspend fun beginAnew() {
        if (run == null) return
        end()
        begin()
    }

    private fun readPairings() {
        paired = Ml2Sensors.receivers(context).map { it.name }
    }

    private suspend fun begin() {
        readPairings()
        check(paired.isNotEmpty()) { "this headset is paired with no receiver; run ml2-receiver pair" }
        val streamer = Ml2Sensors.connect(context, headset, choices.receiver)
        run = Run(streamer, headset.permissions, scope.launch { streamer.state.collect { mutableState.value = it } })
        streamer.start()
    }

    private suspend fun end() {
        val ended = run ?: return
        run = null
        ended.streamer.stop()
        ended.watching.cancelAndJoin()
        mutableState.value = null
    }

    private suspend fun <T> inTurn(block: suspend () -> T): T = scope.async {
        turns.withLock {
            try {
                news = ""
                block()
            } catch (e: Exception) {
                news = e.message ?: e.javaClass.simpleName
                throw e
            }
        }
    }.await()
}
