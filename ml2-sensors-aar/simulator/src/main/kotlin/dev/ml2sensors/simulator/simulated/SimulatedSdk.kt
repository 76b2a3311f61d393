package dev.ml2sensors.simulator.simulated

import java.nio.ByteBuffer

/**
 * native/sim/ml2sim.h, what the simulated headset offers beside the vendor's interfaces: functions, units and axes are
 * stated there. Registered by JNI_OnLoad of libml2sim_jni.so, which [NativeBundle] loads. Any thread.
 */
internal object SimulatedSdk {
    /** What is wrong, or null. */
    @JvmStatic
    external fun set(key: String, value: String): String?

    /** A line for each key, of OpenXR's runtime too; the columns are those of ml2sim_describe_keys. */
    @JvmStatic
    external fun describeKeys(): String

    /** Names the manifest of the OpenXR runtime, before OpenXR is first used. */
    @JvmStatic
    external fun useRuntime(manifest: String)

    /** Whether pictures are being drawn, which takes all processors for seconds. */
    @JvmStatic
    external fun isDrawing(): Boolean

    /** Acceleration, angular velocity and magnetic field of an ml2sim_unit, three numbers each. */
    @JvmStatic
    external fun inertial(unit: Int, boottimeNanos: Long, out: FloatArray)

    @JvmStatic
    external fun light(boottimeNanos: Long): Float

    @JvmStatic
    external fun pressure(unit: Int, boottimeNanos: Long): Float

    /**
     * The JPEG, which stays as it is until the process ends; null for a size or rate that the device does not have.
     *
     * @param numbers receives frame number, MLTime of the capture, exposure in ns, and when the next will be there.
     * @param intrinsics receives 12 numbers as the vendor's tag has them.
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
}
