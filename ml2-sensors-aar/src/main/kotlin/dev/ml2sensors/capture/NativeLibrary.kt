package dev.ml2sensors.capture

import java.nio.file.Path
import kotlin.io.path.absolutePathString

/** libml2sensors.so, which everything else of this package needs to be loaded; once per process. */
public object NativeLibrary {
    @Volatile
    internal var isLoaded: Boolean = false
        private set

    /** From the app's own package, on Android. Throws UnsatisfiedLinkError when it is not there. */
    public fun load() {
        System.loadLibrary("ml2sensors")
        isLoaded = true
    }

    /** From [file]. */
    public fun load(file: Path) {
        System.load(file.absolutePathString())
        isLoaded = true
    }

    /**
     * How [NativeBackend.OPENXR] reaches its runtime: by the loader [library], a path or a name as dlopen takes it,
     * with an instance and a headless session of its own. Before the first such source is collected.
     *
     * @param context on Android the application's android.content.Context, which the loader wants; else null.
     */
    public fun useOpenXr(library: String, context: Any?): Unit = Native.useOpenXr(library, context)
}
