package dev.ml2sensors.unity

import android.content.Context
import dev.ml2sensors.android.AndroidKeys
import dev.ml2sensors.android.Ml2Sensors
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.getAndUpdate
import kotlinx.coroutines.flow.update
import kotlinx.coroutines.withContext
import java.io.IOException

/** Pairs this app with one receiver after another, and knows with which it is paired. Any thread. */
internal class UnityPairing(private val app: Context) {
    private val mutableStatus = MutableStateFlow(UnityStatus.Pairing())
    val status: UnityStatus.Pairing get() = mutableStatus.value

    /** @throws IOException when the receivers cannot be read. */
    suspend fun load() {
        val receivers = withContext(Dispatchers.IO) { AndroidKeys.of(app).receivers }.map(UnityStatus::Receiver)
        mutableStatus.update { it.copy(receivers = receivers) }
    }

    /** False while a pairing is under way; else [run] is to follow. */
    fun begin(): Boolean {
        val before = mutableStatus.getAndUpdate {
            if (it.state == RUNNING) it else it.copy(number = it.number + 1, state = RUNNING, reason = "")
        }
        return before.state != RUNNING
    }

    /** Whether this app is paired now with the receiver that shows [uri]; if not, [status] says why. */
    suspend fun run(uri: String): Boolean = try {
        Ml2Sensors.pair(app, uri)
        load()
        mutableStatus.update { it.copy(state = "paired") }
        true
    } catch (e: IOException) {
        failed(e)
    } catch (e: IllegalArgumentException) {
        failed(e)
    }

    private fun failed(cause: Exception): Boolean {
        mutableStatus.update { it.copy(state = "failed", reason = cause.message ?: cause.javaClass.simpleName) }
        return false
    }

    private companion object {
        const val RUNNING = "running"
    }
}
