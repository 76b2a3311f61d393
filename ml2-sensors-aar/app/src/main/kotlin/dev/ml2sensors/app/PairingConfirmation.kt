package dev.ml2sensors.app

import android.app.Activity
import android.app.AlertDialog
import android.os.Bundle
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.pairing.PairingUri

/** Asks the user before the headset pairs with anything; any app and web page can open a pairing URI. Main thread. */
internal class PairingConfirmation(private val activity: Activity) {
    private var uri: String? = null
    private var dialog: AlertDialog? = null

    /** For what was pasted or opened; null is nothing. */
    fun show(text: String?) {
        close()
        uri = text?.trim() ?: return
        dialog = try {
            question(text.trim(), PairingUri.parse(text.trim()))
        } catch (e: IllegalArgumentException) {
            AlertDialog.Builder(activity).setTitle(R.string.no_code).setMessage(e.message)
        }.setOnCancelListener { uri = null }.show()
    }

    private fun question(text: String, parsed: PairingUri) = AlertDialog.Builder(activity)
        .setTitle(R.string.pair_question)
        .setMessage(activity.getString(R.string.pair_with, parsed.receiver.host, parsed.receiver.fingerprint?.hex))
        .setNegativeButton(R.string.no) { dialog, _ -> dialog.cancel() }
        .setPositiveButton(R.string.pair) { _, _ ->
            uri = null
            StreamingService.pair(activity, text)
        }

    fun close() {
        dialog?.dismiss()
        dialog = null
    }

    fun save(state: Bundle): Unit = state.putString(URI, uri)

    fun restore(state: Bundle): Unit = show(state.getString(URI))

    private companion object {
        const val URI = "uri"
    }
}
