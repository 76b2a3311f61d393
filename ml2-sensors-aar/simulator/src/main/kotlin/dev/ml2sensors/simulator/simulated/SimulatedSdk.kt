package dev.ml2sensors.simulator.simulated

import java.nio.ByteBuffer

/**
 * The controls of the simulated headset. native/sim/ml2sim.h documents the functions, units and axes. JNI_OnLoad of
 * libml2sim_jni.so, which [NativeBundle] loads, registers them. Thread-safe.
 */
internal object SimulatedSdk {
    /** Sets a key. Returns null, or what is wrong with the key or the value. */
    @JvmStatic
    external fun set(key: String, value: String): String?

    /** Returns a line for each key, those of OpenXR too; the columns are those of ml2sim_describe_keys. */
    @JvmStatic
    external fun describeKeys(): String

    /** Sets the manifest of the OpenXR runtime. Call it before OpenXR is first used. */
    @JvmStatic
    external fun useRuntime(manifest: String)

    /** Writes acceleration, angular velocity and magnetic field of an ml2sim_unit, three numbers each. */
    @JvmStatic
    external fun inertial(unit: Int, boottimeNanos: Long, out: FloatArray)

    @JvmStatic
    external fun light(boottimeNanos: Long): Float

    @JvmStatic
    external fun pressure(unit: Int, boottimeNanos: Long): Float

    /**
     * Returns a JPEG that stays valid until the process ends, or null if the device does not have this size or rate.
     *
     * @param numbers receives the frame number, MLTime of the capture, exposure in ns, and time of the next frame.
     * @param intrinsics receives 12 numbers, in the order of the vendor's metadata tag.
     */
    @JvmStatic
    external fun color(
        width: Int,
        height: Int,
        rateHz: Int,
        withHologram: Boolean,
        boottimeNanos: Long,
        numbers: LongArray,
        intrinsics: FloatArray,
    ): ByteBuffer?

    /** Writes the pixels of a whole JPEG of [color] into a direct buffer as NV21, 1.5 bytes for each. */
    @JvmStatic
    external fun colorPixels(jpeg: ByteBuffer, nv21: ByteBuffer)
}
