package dev.ml2sensors.android

import dev.ml2sensors.capture.Native
import dev.ml2sensors.capture.NativeLibrary
import java.nio.file.Path
import kotlin.io.path.absolutePathString
import kotlin.io.path.copyTo
import kotlin.io.path.createTempFile
import kotlin.io.path.deleteExisting

/** The slots of the library that ships, in this class loader. [NativeLibrary] has not loaded it, so nobody views. */
internal object NativeSlots {
    private val loaded by lazy { loadCopy("device/libml2sensors.so") }

    /** Loads the library; later calls do nothing. */
    fun load(): Unit = loaded

    /** The memory of all slots, which are unmapped with the last lease after their stream has ended. */
    val mappedBytes: Long get() = Native.mappedBytes()
}

/** Loads a library of build/native. Robolectric may have several class loaders in a process, and a file is loaded by one. */
internal fun loadCopy(library: String) {
    val copy = createTempFile(suffix = ".so")
    try {
        Path.of("../../build/native", library).copyTo(copy, overwrite = true)
        System.load(copy.absolutePathString())
    } finally {
        copy.deleteExisting()
    }
}
