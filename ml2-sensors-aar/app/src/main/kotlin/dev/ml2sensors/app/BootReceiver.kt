package dev.ml2sensors.app

import android.content.BroadcastReceiver
import android.content.Context
import android.content.Intent
import dev.ml2sensors.app.control.Command

/** Streams when the headset has started, if the user wants that. */
internal class BootReceiver : BroadcastReceiver() {
    override fun onReceive(context: Context, intent: Intent) {
        if (intent.action != Intent.ACTION_BOOT_COMPLETED || !(context.applicationContext as App).choices.atBoot) return
        StreamingService.tell(context, Command.START)
    }
}
