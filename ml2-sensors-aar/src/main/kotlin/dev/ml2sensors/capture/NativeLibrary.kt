package dev.ml2sensors.capture

import java.nio.file.Path
import kotlin.io.path.absolutePathString

/** Loads libml2sensors.so, once per process. Everything else in this package needs it. */
public object NativeLibrary {
    @Volatile
    internal var isLoaded: Boolean = false
        private set

    /**
     * Loads it from the app's own package, on Android.
     *
     * @throws UnsatisfiedLinkError if it is not there.
     */
    public fun load() {
        System.loadLibrary("ml2sensors")
        isLoaded = true
    }

    /** Loads it from [file]. */
    public fun load(file: Path) {
        System.load(file.absolutePathString())
        isLoaded = true
    }

    /**
     * Sets the OpenXR loader that [NativeBackend.OPENXR] uses, with an instance and a headless session of its own. Call
     * it before the first such source is collected.
     *
     * @param library a path or a name, as dlopen takes it.
     * @param context on Android the application's android.content.Context, which the loader needs; else null.
     */
    public fun useOpenXr(library: String, context: Any?): Unit = Native.useOpenXr(library, context)
}
