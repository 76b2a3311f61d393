package dev.ml2sensors.app

import android.app.Notification
import android.app.NotificationChannel
import android.app.NotificationManager
import android.app.PendingIntent
import android.content.Context
import android.content.Intent
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.stream.StreamerState

/** The notification of the service: shows the connection and has a button that stops streaming. */
internal class StreamingNotification(private val context: Context) {
    private val notifications = context.getSystemService(NotificationManager::class.java).apply {
        val name = context.getString(R.string.app_name)
        createNotificationChannel(NotificationChannel(CHANNEL, name, NotificationManager.IMPORTANCE_LOW))
    }
    private var isRemoved = false

    fun of(state: StreamerState?): Notification {
        val stop = PendingIntent.getService(context, 0, StreamingService.intent(context, Command.STOP), 0)
        return Notification.Builder(context, CHANNEL)
            .setSmallIcon(R.drawable.icon)
            .setContentTitle(title(state))
            .setContentIntent(PendingIntent.getActivity(context, 0, Intent(context, MainActivity::class.java), 0))
            .addAction(Notification.Action.Builder(null, context.getString(R.string.stop), stop).build())
            .setOngoing(true)
            .build()
    }

    /** Thread-safe, as [remove], after which it does nothing: a state may be on its way while the service ends. */
    @Synchronized
    fun show(state: StreamerState?) {
        if (!isRemoved) notifications.notify(ID, of(state))
    }

    @Synchronized
    fun remove() {
        isRemoved = true
        notifications.cancel(ID)
    }

    private fun title(state: StreamerState?) = when (state) {
        is StreamerState.Connected -> context.getString(R.string.connected, state.receiverName)
        else -> context.getString(R.string.connecting)
    }

    companion object {
        const val ID = 1
        private const val CHANNEL = "streaming"
    }
}
