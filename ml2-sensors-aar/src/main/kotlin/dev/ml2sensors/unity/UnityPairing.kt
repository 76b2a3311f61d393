package dev.ml2sensors.unity

import android.content.Context
import dev.ml2sensors.android.AndroidKeys
import dev.ml2sensors.android.Ml2Sensors
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.withContext
import java.io.IOException

/** Pairs this app with one receiver after another, and knows with which it is paired. Any thread. */
internal class UnityPairing(private val app: Context) {
    /** The last one last; as of the last [load]. */
    @Volatile
    var receivers: List<UnityStatus.Receiver> = emptyList()
        private set

    @Volatile
    var status: UnityStatus.Pairing = UnityStatus.Pairing()
        private set

    /** @throws IOException when they cannot be read. */
    suspend fun load() {
        receivers = withContext(Dispatchers.IO) { AndroidKeys.of(app).receivers }.map(UnityStatus::Receiver)
    }

    /** False while a pairing is under way; else [run] is to follow. */
    @Synchronized
    fun begin(): Boolean {
        if (status.state == RUNNING) return false
        status = UnityStatus.Pairing(status.number + 1, RUNNING)
        return true
    }

    /** Whether this app is paired with the receiver that shows [uri] now; if not, [status] says why. */
    suspend fun run(uri: String): Boolean {
        val failure = try {
            Ml2Sensors.pair(app, uri)
            load()
            null
        } catch (e: IOException) {
            e
        } catch (e: IllegalArgumentException) {
            e
        }
        val number = status.number
        status =
            if (failure == null) {
                UnityStatus.Pairing(number, "paired")
            } else {
                UnityStatus.Pairing(number, "failed", failure.message ?: failure.javaClass.simpleName)
            }
        return failure == null
    }

    private companion object {
        const val RUNNING = "running"
    }
}
