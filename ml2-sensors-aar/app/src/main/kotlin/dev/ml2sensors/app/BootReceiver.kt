package dev.ml2sensors.app

import android.content.BroadcastReceiver
import android.content.Context
import android.content.Intent
import dev.ml2sensors.app.control.Command

/** Starts to stream when the headset has booted, if the user has enabled that. */
internal class BootReceiver : BroadcastReceiver() {
    override fun onReceive(context: Context, intent: Intent) {
        if (intent.action != Intent.ACTION_BOOT_COMPLETED ||
            !(context.applicationContext as App).settings.startAtBoot
        ) {
            return
        }
        StreamingService.send(context, Command.START)
    }
}
