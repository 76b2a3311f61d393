package dev.ml2sensors.android

import dev.ml2sensors.capture.NativeBackend
import dev.ml2sensors.capture.NativeLibrary
import dev.ml2sensors.capture.NativePixelSource
import dev.ml2sensors.capture.NativeReadingSource
import dev.ml2sensors.capture.NativeSource
import dev.ml2sensors.capture.PixelSensor
import dev.ml2sensors.table.StreamTable

/**
 * Returns every sensor of libml2sensors.so with every backend, or null if the device has no such library, as on another
 * ABI.
 *
 * @param suspendedNanos as [dev.ml2sensors.source.Headset.suspendedNanos].
 */
internal fun loadNativeSources(suspendedNanos: () -> Long): List<NativeSource>? {
    try {
        NativeLibrary.load()
    } catch (_: UnsatisfiedLinkError) {
        return null
    }
    val pixels = NativeBackend.entries.flatMap { backend ->
        PixelSensor.entries.filter { it != PixelSensor.COLOR || backend == NativeBackend.OPENXR }
            .map { NativePixelSource(it, backend) }
    }
    val readings = NativeBackend.entries.flatMap { NativeReadingSource.all(it, suspendedNanos) }
    return pixels + readings
}

/** Returns sources that refuse all streams of the missing library. */
internal fun absentNativeSources(): List<UnavailableSource> = NativeBackend.entries.map { backend ->
    val streams = StreamTable.all.filterTo(LinkedHashSet()) { backend.id in it.backends }
    UnavailableSource(backend.id, streams, "not available: libml2sensors.so")
}
