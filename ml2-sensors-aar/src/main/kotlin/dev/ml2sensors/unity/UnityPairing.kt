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

/** Pairs this app with receivers, and knows with which it is paired. Thread-safe. */
internal class UnityPairing(private val app: Context) {
    private val mutableStatus = MutableStateFlow(UnityStatus.Pairing())
    val status: UnityStatus.Pairing get() = mutableStatus.value

    /**
     * Reads the paired receivers.
     *
     * @throws IOException when they cannot be read.
     */
    suspend fun load() {
        val receivers = withContext(Dispatchers.IO) { AndroidKeys.of(app).receivers }.map(UnityStatus::Receiver)
        mutableStatus.update { it.copy(receivers = receivers) }
    }

    /** Starts a pairing, which [run] continues; returns false if one is running. */
    fun begin(): Boolean {
        val before = mutableStatus.getAndUpdate {
            if (it.state == RUNNING) it else it.copy(number = it.number + 1, state = RUNNING, reason = "")
        }
        return before.state != RUNNING
    }

    /** Pairs with the receiver that shows [uri]; returns false if it failed, and [status] says why. */
    suspend fun run(uri: String): Boolean = try {
        var replaced = ""
        Ml2Sensors.pair(app, uri) { replaced = it }
        load()
        mutableStatus.update { it.copy(state = "paired", reason = replaced) }
        true
    } catch (e: IOException) {
        failed(e)
    } catch (e: IllegalArgumentException) {
        failed(e)
    }

    /** Gives up a pairing that runs; the receiver may know this app nevertheless. */
    fun close(): Unit = mutableStatus.update {
        if (it.state == RUNNING) it.copy(state = FAILED, reason = "it was closed meanwhile") else it
    }

    private fun failed(cause: Exception): Boolean {
        mutableStatus.update { it.copy(state = FAILED, reason = cause.message ?: cause.javaClass.simpleName) }
        return false
    }

    private companion object {
        const val RUNNING = "running"
        const val FAILED = "failed"
    }
}
