package dev.ml2sensors.app.heat

import android.content.Context
import android.content.Intent
import android.content.IntentFilter
import android.os.BatteryManager

/** The temperature that Android has told last; null where it told none. */
internal fun batteryCelsius(context: Context): Double? {
    val told = context.registerReceiver(null, IntentFilter(Intent.ACTION_BATTERY_CHANGED)) ?: return null
    val tenths = told.getIntExtra(BatteryManager.EXTRA_TEMPERATURE, Int.MIN_VALUE)
    return if (tenths == Int.MIN_VALUE) null else tenths / TENTHS_PER_DEGREE
}

private const val TENTHS_PER_DEGREE = 10.0
