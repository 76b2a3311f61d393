package dev.ml2sensors.app

import android.annotation.SuppressLint
import android.content.Context
import android.net.wifi.WifiManager
import android.os.PowerManager

/**
 * Keeps processor and Wi-Fi awake. Android honours the low latency only while the screen is on and the app in front;
 * elsewhere it is high performance that remains.
 */
internal class Locks(context: Context) {
    private val processor =
        context.getSystemService(PowerManager::class.java).newWakeLock(PowerManager.PARTIAL_WAKE_LOCK, TAG)
    private val wifi = listOf(WifiManager.WIFI_MODE_FULL_HIGH_PERF, WifiManager.WIFI_MODE_FULL_LOW_LATENCY)
        .mapNotNull { context.getSystemService(WifiManager::class.java)?.createWifiLock(it, TAG) }

    init {
        processor.setReferenceCounted(false)
        wifi.forEach { it.setReferenceCounted(false) }
    }

    /** However long the user streams. */
    @SuppressLint("WakelockTimeout")
    fun hold() {
        processor.acquire()
        wifi.forEach { it.acquire() }
    }

    fun release() {
        processor.release()
        wifi.forEach { it.release() }
    }

    private companion object {
        const val TAG = "ml2sensors:streaming"
    }
}
