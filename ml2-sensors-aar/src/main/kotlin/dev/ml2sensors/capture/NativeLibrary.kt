package dev.ml2sensors.capture

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.SourceException
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

    /**
     * Opens the depth, world and eye cameras and the head tracker of the vendor's SDK, for a program without Android's
     * other sensors. Call [load] first. Close the result when it is no longer needed.
     */
    public fun openHeadset(identity: Headset.Identity): Headset {
        check(isLoaded) { "libml2sensors.so is not loaded; call NativeLibrary.load first" }
        val cameras = listOf(PixelSensor.DEPTH, PixelSensor.WORLD, PixelSensor.EYE)
        val sources = cameras.map { NativePixelSource(it, NativeBackend.SDK) }
        val head = NativeReadingSource(ReadingSensor.HEAD, NativeBackend.SDK)
        return SensorHeadset(identity, NativeHeadsetClock, sources + head)
    }
}

/** CLOCK_BOOTTIME, read by the library that stamps frames. Thread-safe. */
internal object NativeHeadsetClock : DeviceClock {
    override fun nowNanos(): Long = Native.now()
}

/** A sensor of the device cannot be used, or no longer. The message names what is missing or what failed. */
internal sealed class CaptureException(message: String) : SourceException(message) {
    /** A library or symbol is missing, or the device has no such sensor. */
    class NotAvailable internal constructor(message: String) : CaptureException(message)

    /** The app has not, or no longer, the Android permission that the sensor needs. */
    class PermissionDenied @JvmOverloads internal constructor(
        message: String,
        override val permission: String? = null,
    ) : CaptureException(message)

    /** Another use in this process excludes this one. */
    class InUse internal constructor(message: String) : CaptureException(message)

    /** A call of the vendor's API failed. */
    class VendorFailure internal constructor(message: String) : CaptureException(message)
}
