package dev.ml2sensors.capture

import dev.ml2sensors.message.MlPose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Vector3
import java.nio.ByteBuffer
import java.nio.file.Path
import kotlin.io.path.absolute
import kotlin.io.path.createDirectories
import kotlin.test.assertEquals
import kotlin.test.assertNull

/** The simulated device of this process, native/sim/ml2sim.h, with the library that it is for. */
internal object Simulation {
    /** No camera of ml2sim_camera. */
    const val HEAD = -1

    init {
        NativeLibrary.load(Path.of("../build/native/device/libml2sensors.so"))
        System.load(Path.of("../build/native/host/tests/jni/libml2sim_control.so").toRealPath().toString())
    }

    /** Sets a key of ml2sim_describe_keys, until [begin]. */
    fun configure(key: String, value: Any): Unit = assertNull(set(key, value.toString()))

    /** A new device without noise, with cached frames of two seconds, all of one seed. */
    fun begin() {
        reset()
        configure("noise", 0)
        configure("loop_seconds", 2)
        configure("cache", Path.of("target/frame_cache").createDirectories().absolute())
    }

    /** Everything that was taken from the device was given back, and nothing was done wrong. */
    fun assertIsLeftAsFound() {
        assertEquals("", lastMisuse())
        assertEquals(0, openHandles())
    }

    /** Returns the true pose of a camera of ml2sim_camera, or of [HEAD], at an instant of CLOCK_BOOTTIME. */
    fun truth(camera: Int, boottimeNanos: Long): MlPose {
        val values = truePose(camera, boottimeNanos)
        return MlPose(
            Vector3(values[4], values[5], values[6]),
            Quaternion(values[0], values[1], values[2], values[3]),
        )
    }

    private external fun set(key: String, value: String): String?

    private external fun reset()

    /** Returns the oldest message of an inbox as a native reader does, or null. */
    external fun takeMessage(inbox: Int): ByteArray?

    /** ml2s_acquire_latest, which Kotlin itself has no use for, into [frame], a direct buffer of one ml2s_frame. */
    external fun acquireLatest(stream: Int, afterNanos: Long, frame: ByteBuffer): Boolean

    /** Calls the static [method] of [type] from a thread that no class has begun; returns what it threw. */
    external fun callNatively(type: Class<*>, method: String, argument: String?): Throwable?

    /** With the key clock=manual. */
    external fun advance(nanos: Long)

    /** And what is lent by them. */
    external fun openHandles(): Int

    /** The MLTime of an instant of CLOCK_BOOTTIME. */
    external fun mlTime(boottimeNanos: Long): Long

    external fun lastMisuse(): String

    private external fun truePose(camera: Int, boottimeNanos: Long): DoubleArray
}
