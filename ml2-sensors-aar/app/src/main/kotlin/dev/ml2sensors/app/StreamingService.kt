package dev.ml2sensors.app

import android.app.Service
import android.content.Context
import android.content.Intent
import android.os.IBinder
import android.util.Log
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.app.control.Control
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.cancel
import kotlinx.coroutines.flow.filterNotNull
import kotlinx.coroutines.launch

/**
 * Streams in the foreground while another app is in front. Told what to do by the intents of [Command], by the app
 * itself or over adb, and answers each with lines of JSON in logcat. Android starts it again when its process has died.
 */
internal class StreamingService : Service() {
    private val app get() = application as App
    private val tasks = CoroutineScope(SupervisorJob() + Dispatchers.Default)
    private val control by lazy { Control(app.streaming, app.choices) }
    private val locks by lazy { Locks(this) }
    private val notice by lazy { Notice(this) }

    override fun onCreate() {
        tasks.launch { app.streaming.state.filterNotNull().collect(notice::show) }
    }

    override fun onStartCommand(intent: Intent?, flags: Int, startId: Int): Int {
        startForeground(Notice.ID, notice.of(app.streaming.state.value))
        // Begun at once, so that what comes next is done next
        tasks.launch(start = CoroutineStart.UNDISPATCHED) {
            val request = intent?.getStringExtra("request").orEmpty()
            control.answer(request, intent?.action) { intent?.extras?.get(it) }.forEach { Log.i(TAG, "$it") }
            if (app.streaming.isOn) locks.hold() else finish(startId)
        }
        return START_STICKY
    }

    /** Unless something was asked for in the meantime. */
    private fun finish(startId: Int) {
        locks.release()
        stopSelf(startId)
    }

    override fun onDestroy() {
        // What this begins goes on by itself
        tasks.launch(start = CoroutineStart.UNDISPATCHED) { app.streaming.stop() }
        tasks.cancel()
        locks.release()
        notice.remove()
    }

    override fun onBind(intent: Intent): IBinder? = null

    companion object {
        /** Of the lines in logcat. */
        const val TAG = "ml2-sensors"

        /** Tells the service an [action] of [Command]. */
        fun tell(context: Context, action: String): Unit = tell(context, intent(context, action))

        /** Pairs as of a [uri] that the user has confirmed, and streams. */
        fun pair(
            context: Context,
            uri: String,
        ): Unit = tell(context, intent(context, Command.PAIR).putExtra("uri", uri))

        fun intent(context: Context, action: String): Intent =
            Intent(context, StreamingService::class.java).setAction(action)

        private fun tell(context: Context, intent: Intent) {
            context.startForegroundService(intent)
        }
    }
}
