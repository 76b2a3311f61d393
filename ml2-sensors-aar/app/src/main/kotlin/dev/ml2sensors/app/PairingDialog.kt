package dev.ml2sensors.app

import android.app.Activity
import android.app.AlertDialog
import android.os.Bundle
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.pairing.PairingUri

/** Asks the user before the headset pairs, since any app or web page can open a pairing URI. Main thread. */
internal class PairingDialog(private val activity: Activity) {
    private var uri: String? = null
    private var dialog: AlertDialog? = null

    /** Asks about a URI that was pasted or opened; does nothing for null. */
    fun show(text: String?) {
        close()
        uri = text?.trim() ?: return
        dialog = try {
            confirmation(text.trim(), PairingUri.parse(text.trim()))
        } catch (e: IllegalArgumentException) {
            AlertDialog.Builder(activity).setTitle(R.string.invalid_uri).setMessage(e.message)
        }.setOnCancelListener { uri = null }.show()
    }

    private fun confirmation(text: String, parsed: PairingUri) = AlertDialog.Builder(activity)
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
