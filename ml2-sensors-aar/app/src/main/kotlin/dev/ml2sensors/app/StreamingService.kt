package dev.ml2sensors.app

import android.app.Service
import android.content.Context
import android.content.Intent
import android.os.IBinder
import android.util.Log
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.app.control.CommandHandler
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.SupervisorJob
import kotlinx.coroutines.cancel
import kotlinx.coroutines.flow.filterNotNull
import kotlinx.coroutines.launch

/**
 * Streams as a foreground service, also while another app is in front. It takes the intents of [Command], from the app
 * or over adb, and replies to each with lines of JSON in logcat. Android restarts it after its process has died.
 */
internal class StreamingService : Service() {
    private val app get() = application as App
    private val tasks = CoroutineScope(SupervisorJob() + Dispatchers.Default)
    private val commands by lazy { CommandHandler(app.streaming, app.settings) }
    private val wakeLocks by lazy { WakeLocks(this) }
    private val notification by lazy { StreamingNotification(this) }

    override fun onCreate() {
        tasks.launch { app.streaming.state.filterNotNull().collect(notification::show) }
    }

    override fun onStartCommand(intent: Intent?, flags: Int, startId: Int): Int {
        startForeground(StreamingNotification.ID, notification.of(app.streaming.state.value))
        // Undispatched, so that commands are carried out in the order of their intents
        tasks.launch(start = CoroutineStart.UNDISPATCHED) {
            val request = intent?.getStringExtra("request").orEmpty()
            commands.reply(request, intent?.action) { intent?.extras?.get(it) }.forEach { Log.i(TAG, "$it") }
            if (app.streaming.isOn) wakeLocks.hold() else finish(startId)
        }
        return START_STICKY
    }

    /** Stops the service, unless another command has arrived. */
    private fun finish(startId: Int) {
        wakeLocks.release()
        stopSelf(startId)
    }

    override fun onDestroy() {
        // The controller finishes this even though the scope is cancelled
        tasks.launch(start = CoroutineStart.UNDISPATCHED) { app.streaming.stop() }
        tasks.cancel()
        wakeLocks.release()
        notification.remove()
    }

    override fun onBind(intent: Intent): IBinder? = null

    companion object {
        /** The tag of the lines in logcat. */
        const val TAG = "ml2-sensors"

        /** Sends an [action] of [Command] to the service. */
        fun send(context: Context, action: String): Unit = send(context, intent(context, action))

        /** Pairs with a [uri] that the user has confirmed, then streams. */
        fun pair(
            context: Context,
            uri: String,
        ): Unit = send(context, intent(context, Command.PAIR).putExtra("uri", uri))

        fun intent(context: Context, action: String): Intent =
            Intent(context, StreamingService::class.java).setAction(action)

        private fun send(context: Context, intent: Intent) {
            context.startForegroundService(intent)
        }
    }
}
