package dev.ml2sensors.app

import android.app.Application

/** What activity and service have in common lives as long as the process. */
internal class App : Application() {
    val choices by lazy { Choices(this) }
    val streaming by lazy { Streaming(this, choices) }
}
