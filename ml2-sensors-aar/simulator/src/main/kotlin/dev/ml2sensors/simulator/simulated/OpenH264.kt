package dev.ml2sensors.simulator.simulated

import java.nio.ByteBuffer

/**
 * Cisco's encoder, if this machine has it. JNI_OnLoad of libml2sim_openh264.so, which [NativeBundle]
 * loads, registers these functions. An encoder is used by one thread at a time.
 */
internal object OpenH264 {
    /** Returns null, or why there is no encoder on this machine. */
    @JvmStatic
    external fun refusal(): String?

    /** Opens an encoder of constant bit rate, which makes key frames only when it is asked; returns 0 if it refuses. */
    @JvmStatic
    external fun open(width: Int, height: Int, rateHz: Int, bitsPerSecond: Int): Long

    /**
     * Encodes [luma] and the pairs of V and U in [chroma] into [output]; all are direct buffers, and rows have
     * [strideBytes]. Returns the size of the access unit in bytes: 0 if the image was left out, -1 if the encoder fails or
     * [output] is too small.
     */
    @JvmStatic
    external fun encode(
        encoder: Long,
        luma: ByteBuffer,
        chroma: ByteBuffer,
        strideBytes: Int,
        presentationMicros: Long,
        asKeyFrame: Boolean,
        output: ByteBuffer,
    ): Int

    @JvmStatic
    external fun close(encoder: Long)
}
