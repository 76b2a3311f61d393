package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.capture.NativeLibrary
import java.nio.file.Files
import java.nio.file.Path
import kotlin.io.path.createTempDirectory
import kotlin.io.path.deleteExisting

/**
 * All native code of the simulated headset, as native/sim/bundle.sh puts it into this program's jar: unpacked to a
 * temporary folder and loaded from there in the order it states. Libraries find each other by name, since the loader
 * takes what the process has; so no path is to be set.
 */
internal object NativeBundle {
    private const val FOLDER = "/dev/ml2sensors/simulator/native"
    private const val DEVICE_LIBRARY = "libml2sensors.so"
    private const val RUNTIME_MANIFEST = "openxr_runtime.json"

    /** Khronos', by the name under which the bundle has it loaded. */
    private const val OPENXR_LOADER = "libopenxr_loader.so.1"

    private val loaded by lazy(::unpackAndLoad)

    /** Once per process; at any later time it does nothing. */
    fun load(): Unit = loaded

    @Suppress("UnsafeDynamicallyLoadedCode") // The path is that of a file just unpacked
    private fun unpackAndLoad() {
        val folder = createTempDirectory("ml2-headset").apply { toFile().deleteOnExit() }
        for (name in resource("order").use { it.readBytes().decodeToString() }.lines().filter(String::isNotEmpty)) {
            unpacked(folder, name) { System.load("$it") }
        }
        unpacked(folder, DEVICE_LIBRARY, NativeLibrary::load)
        // The loader of OpenXR reads it when it is first asked for something
        SimulatedSdk.useRuntime("${unpack(folder, RUNTIME_MANIFEST).apply { toFile().deleteOnExit() }}")
        NativeLibrary.useOpenXr(OPENXR_LOADER, context = null)
    }

    /** A library that is loaded needs its file no more; so processes that are killed leave none. */
    private inline fun unpacked(folder: Path, name: String, use: (Path) -> Unit) {
        val file = unpack(folder, name)
        try {
            use(file)
        } finally {
            file.deleteExisting()
        }
    }

    private fun unpack(folder: Path, name: String): Path =
        folder.resolve(name).also { file -> resource(name).use { Files.copy(it, file) } }

    private fun resource(name: String) =
        NativeBundle::class.java.getResourceAsStream("$FOLDER/$name")
            ?: throw UnsatisfiedLinkError("$FOLDER/$name is not in the jar of the simulated headset: run make build")
}
