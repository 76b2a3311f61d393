package dev.ml2sensors.capture

import org.junit.jupiter.api.Test
import java.nio.file.Path
import java.util.concurrent.CopyOnWriteArrayList
import kotlin.io.path.absolute
import kotlin.io.path.absolutePathString
import kotlin.io.path.copyTo
import kotlin.io.path.createDirectories
import kotlin.io.path.createTempFile
import kotlin.io.path.deleteExisting
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertIs
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** The library in a process where the vendor's is whole, missing or not all there. */
class LibraryTest {
    @Test
    fun theVirtualMachineFindsNothingWrongWithItsUseOfJni() {
        val lines = probe(Path.of("../build/native/host/sim"))
        val expected = listOf(
            "depth: accepted; ImageSample",
            "world_left: accepted; ImageSample",
            "eye_nasal_left: accepted; ImageSample",
            "head_pose: accepted; PoseSample",
            "controller_joy: accepted; InputSample",
        )
        assertEquals(expected, lines.filter { ": accepted" in it })
        assertFalse(lines.any { "WARNING" in it || "FATAL" in it }, lines.joinToString("\n"))
    }

    /** Unity's GameActivity calls from a native thread, where the system's loader looks for libraries. */
    @Test
    fun theLibraryIsLookedForByTheLoaderOfOurClassesWhateverThreadCalls() {
        val library = createTempFile(suffix = ".so")
        Path.of("../build/native/device/libml2sensors.so").copyTo(library, overwrite = true)
        val app = AppLoader(checkNotNull(javaClass.classLoader), library)
        assertIs<UnsatisfiedLinkError>(Simulation.callNatively(System::class.java, "loadLibrary", "ml2sensors"))
        assertEquals(emptyList(), app.lookedFor)
        assertNull(Simulation.callNatively(app.loadClass("dev.ml2sensors.unity.Ml2Unity"), "loadLibrary", null))
        assertEquals(listOf("ml2sensors"), app.lookedFor)
        library.deleteExisting()
    }

    /** Loads our classes as an app's loader does, which knows where the app's libraries are. */
    private class AppLoader(parent: ClassLoader, private val library: Path) : ClassLoader(parent) {
        val lookedFor = CopyOnWriteArrayList<String>()

        override fun loadClass(name: String, resolve: Boolean): Class<*> {
            if (!name.startsWith("dev.ml2sensors.")) return super.loadClass(name, resolve)
            findLoadedClass(name)?.let { return it }
            val file = name.replace('.', '/') + ".class"
            val bytes = (parent.getResourceAsStream(file) ?: throw ClassNotFoundException(name)).use { it.readBytes() }
            return defineClass(name, bytes, 0, bytes.size)
        }

        override fun findLibrary(name: String): String {
            lookedFor += name
            return library.absolutePathString()
        }
    }

    @Test
    fun aMissingLibraryIsNamedInEveryRefusal() {
        val lines = sdk(probe(Path.of("no-such-folder")))
        assertEquals(
            listOf("depth", "world_left", "eye_nasal_left", "head_pose", "controller_joy"),
            lines.map {
                it.substringBefore(':')
            },
        )
        for (line in lines) {
            val (answer, end) = line.substringAfter(": ").split("; ")
            assertTrue(answer.startsWith("not available: libperception.magicleap.so"), line)
            assertEquals("NotAvailable: $answer", end)
        }
    }

    @Test
    fun aMissingSymbolIsNamedWhereItIsNeeded() {
        fun missing(stream: String, symbol: String): String {
            val reason = "not available: libperception.magicleap.so/$symbol"
            return "$stream: $reason; NotAvailable: $reason"
        }
        val expected = listOf(
            missing("depth", "MLDepthCameraUpdateSettings"),
            missing("world_left", "MLWorldCameraConnect"),
            missing("eye_nasal_left", "MLEyeCameraConnect"),
            missing("head_pose", "MLHeadTrackingCreate"),
            missing("controller_joy", "MLTimeConvertMLTimeToSystemTime"),
        )
        assertEquals(expected, sdk(probe(Path.of("../build/native/host/tests/jni/partial"))))
    }

    @Test
    fun openXrIsRefusedUntilItsLoaderIsThere() {
        val (without, absent) = probe(Path.of("no-such-folder")).filter { it.startsWith("gaze") }
        val reason = "not available: OpenXR (ml2s_use_openxr was not called)"
        assertEquals("gaze: $reason; NotAvailable: $reason", without)
        assertTrue(absent.startsWith("gaze: not available: libno-such-loader.so"), absent)
        assertTrue("; NotAvailable: not available: libno-such-loader.so" in absent, absent)
    }

    /** Returns the lines of the sensors that come by the vendor's SDK. */
    private fun sdk(lines: List<String>) = lines.filterNot { it.startsWith("gaze") }

    /** The lines that [Probe] prints with the vendor's library from [folder]. */
    private fun probe(folder: Path): List<String> {
        val java = Path.of(System.getProperty("java.home"), "bin", "java").toString()
        val classes = System.getProperty("surefire.test.class.path") ?: System.getProperty("java.class.path")
        val builder = ProcessBuilder(java, "-Xcheck:jni", "-cp", classes, Probe::class.java.name)
        val folders = listOf(Path.of("../build/native/linux"), folder).joinToString(":") { it.absolute().toString() }
        builder.environment()["LD_LIBRARY_PATH"] = folders
        val cache = Path.of("target/frame_cache").createDirectories().absolute()
        builder.environment()["ML2SIM"] = "loop_seconds=2,cache=$cache"
        val process = builder.redirectErrorStream(true).start()
        val lines = process.inputReader().readLines()
        assertEquals(0, process.waitFor(), lines.joinToString("\n"))
        return lines
    }
}
