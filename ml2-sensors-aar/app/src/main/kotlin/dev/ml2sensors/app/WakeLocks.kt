package dev.ml2sensors.app

import android.annotation.SuppressLint
import android.content.Context
import android.net.wifi.WifiManager
import android.os.PowerManager

/**
 * Keeps the processor and Wi-Fi awake. Android honours the low-latency lock only while the screen is on and the app is
 * in front. At other times the high-performance lock has effect.
 */
internal class WakeLocks(context: Context) {
    private val processor =
        context.getSystemService(PowerManager::class.java).newWakeLock(PowerManager.PARTIAL_WAKE_LOCK, TAG)
    private val wifi = listOf(WifiManager.WIFI_MODE_FULL_HIGH_PERF, WifiManager.WIFI_MODE_FULL_LOW_LATENCY)
        .mapNotNull { context.getSystemService(WifiManager::class.java)?.createWifiLock(it, TAG) }

    init {
        processor.setReferenceCounted(false)
        wifi.forEach { it.setReferenceCounted(false) }
    }

    /** Holds the locks for as long as the user streams, without a timeout. */
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
