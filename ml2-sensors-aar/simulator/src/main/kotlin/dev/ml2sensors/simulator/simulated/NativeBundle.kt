package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.capture.NativeLibrary
import java.nio.file.Files
import java.nio.file.Path
import kotlin.io.path.createTempDirectory
import kotlin.io.path.deleteExisting

/**
 * Loads the native code of the simulated headset from this program's jar, where native/sim/bundle.sh puts it. Unpacks
 * each library to a temporary folder and loads it, in the order that the bundle states. Libraries find each other by
 * name, since the loader uses what the process has loaded; so no library path is needed.
 */
internal object NativeBundle {
    private const val FOLDER = "/dev/ml2sensors/simulator/native"
    private const val DEVICE_LIBRARY = "libml2sensors.so"
    private const val RUNTIME_MANIFEST = "openxr_runtime.json"

    /** Khronos' OpenXR loader, by the name under which the bundle loads it. */
    private const val OPENXR_LOADER = "libopenxr_loader.so.1"

    private val loaded by lazy(::unpackAndLoad)

    /** Loads the libraries once per process; later calls do nothing. */
    fun load(): Unit = loaded

    @Suppress("UnsafeDynamicallyLoadedCode") // The path is that of a file that was just unpacked
    private fun unpackAndLoad() {
        val folder = createTempDirectory("ml2-headset").apply { toFile().deleteOnExit() }
        for (name in resource("order").use { it.readBytes().decodeToString() }.lines().filter(String::isNotEmpty)) {
            unpacked(folder, name) { System.load("$it") }
        }
        unpacked(folder, DEVICE_LIBRARY, NativeLibrary::load)
        // The OpenXR loader reads the manifest when it is first used
        SimulatedSdk.useRuntime("${unpack(folder, RUNTIME_MANIFEST).apply { toFile().deleteOnExit() }}")
        NativeLibrary.useOpenXr(OPENXR_LOADER, context = null)
    }

    /** Deletes the file of a library once it is loaded, so that a killed process leaves no files. */
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
