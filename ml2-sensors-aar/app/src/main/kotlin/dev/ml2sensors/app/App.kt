package dev.ml2sensors.app

import android.app.Application

/** Holds the objects that activity and service share, for the lifetime of the process. */
internal class App : Application() {
    val settings by lazy { AppSettings(this) }
    val streaming by lazy { StreamController(this, settings) }
}
