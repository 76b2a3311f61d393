package dev.ml2sensors.app

import android.content.Context
import android.content.SharedPreferences
import kotlin.properties.ReadWriteProperty
import kotlin.reflect.KProperty

/** What the user has chosen, kept over restarts of the app and of the headset. Any thread. */
internal class Choices(context: Context) {
    private val kept = context.getSharedPreferences("choices", Context.MODE_PRIVATE)

    /** To stream; also again after the process has died, and with [atBoot] after the headset has started. */
    var streams: Boolean by Flag(kept)
    var atBoot: Boolean by Flag(kept)

    /** To let cameras rest while the headset is hot. */
    var coolsDown: Boolean by Flag(kept)

    /** A name or `HOST:PORT`; empty for the receiver that the headset is paired with, wherever it is. */
    var receiver: String
        get() = kept.getString(RECEIVER, "").orEmpty()
        set(value) = kept.edit().putString(RECEIVER, value).apply()

    private class Flag(private val kept: SharedPreferences) : ReadWriteProperty<Choices, Boolean> {
        override fun getValue(thisRef: Choices, property: KProperty<*>) = kept.getBoolean(property.name, false)

        override fun setValue(thisRef: Choices, property: KProperty<*>, value: Boolean) =
            kept.edit().putBoolean(property.name, value).apply()
    }

    private companion object {
        const val RECEIVER = "receiver"
    }
}
