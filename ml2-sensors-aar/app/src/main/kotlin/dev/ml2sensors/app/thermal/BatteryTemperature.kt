package dev.ml2sensors.app.thermal

import android.content.Context
import android.content.Intent
import android.content.IntentFilter
import android.os.BatteryManager

/** Returns the battery temperature that Android reported last, or null if it reported none. */
internal fun batteryCelsius(context: Context): Double? {
    val intent = context.registerReceiver(null, IntentFilter(Intent.ACTION_BATTERY_CHANGED)) ?: return null
    val tenths = intent.getIntExtra(BatteryManager.EXTRA_TEMPERATURE, Int.MIN_VALUE)
    return if (tenths == Int.MIN_VALUE) null else tenths / TENTHS_PER_DEGREE
}

private const val TENTHS_PER_DEGREE = 10.0
