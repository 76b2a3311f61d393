package dev.ml2sensors.app

import android.content.Context
import android.content.SharedPreferences
import kotlin.properties.ReadWriteProperty
import kotlin.reflect.KProperty

/** The user's settings, kept over restarts of the app and of the headset. Thread-safe. */
internal class AppSettings(context: Context) {
    private val preferences = context.getSharedPreferences("settings", Context.MODE_PRIVATE)

    /** True from START to STOP. If true, streaming resumes after the process has died. */
    var isStreaming: Boolean by Flag(preferences)

    /** True to start streaming when the headset has booted. */
    var startAtBoot: Boolean by Flag(preferences)

    /** True to pause cameras while the headset is hot. */
    var pauseWhenHot: Boolean by Flag(preferences)

    /** True to show the sample of a robot's arm. */
    var showRobot: Boolean by Flag(preferences)

    /** The receiver's name or `HOST:PORT`; empty for the paired receiver, found on the network. */
    var receiver: String
        get() = preferences.getString(RECEIVER, "").orEmpty()
        set(value) = preferences.edit().putString(RECEIVER, value).apply()

    private class Flag(private val preferences: SharedPreferences) : ReadWriteProperty<AppSettings, Boolean> {
        override fun getValue(
            thisRef: AppSettings,
            property: KProperty<*>,
        ) = preferences.getBoolean(property.name, false)

        override fun setValue(thisRef: AppSettings, property: KProperty<*>, value: Boolean) =
            preferences.edit().putBoolean(property.name, value).apply()
    }

    private companion object {
        const val RECEIVER = "receiver"
    }
}
