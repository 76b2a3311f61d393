package dev.ml2sensors.capture

import java.nio.ByteBuffer

/**
 * The functions of native/sdk/ml2s.h, one to one: threads, ownership and units are stated there. Registered by
 * JNI_OnLoad of libml2sensors.so, which [NativeLibrary] loads.
 *
 * What ml2s.h calls an error is thrown: a [CaptureException], or IllegalStateException for a closed handle or another
 * thread than the handle's, or IllegalArgumentException.
 */
internal object Native {
    @JvmStatic
    external fun now(): Long

    @JvmStatic
    external fun boottimeOf(deviceNanos: Long): Long

    /** Returns the size of ml2s_frame and the offsets of its fields, in the order in which [FrameBlock] reads them. */
    @JvmStatic
    external fun frameLayout(): IntArray

    /** Returns those of ml2s_pose, in the order in which [PoseBlock] reads them. */
    @JvmStatic
    external fun poseLayout(): IntArray

    /** Returns those of ml2s_settings, in the order in which [NativeSettings] reads them. */
    @JvmStatic
    external fun settingsLayout(): IntArray

    @JvmStatic
    external fun check(sensor: Int, backend: Int)

    /** Opens the sensor of the ml2s_settings in [settings], a direct buffer; returns its handle. */
    @JvmStatic
    external fun open(settings: ByteBuffer): Long

    /** Changes the streams of [handle] to those of the ml2s_settings in [settings], a direct buffer. */
    @JvmStatic
    external fun configure(handle: Long, settings: ByteBuffer)

    /** How many of the ml2s_frame in [frames], a direct buffer, were filled; 0 after the timeout. */
    @JvmStatic
    external fun poll(handle: Long, timeoutNanos: Long, frames: ByteBuffer): Int

    /** How many of the ml2s_pose in [poses], a direct buffer, were filled. */
    @JvmStatic
    external fun pollPoses(handle: Long, poses: ByteBuffer): Int

    /** Whether the pose was known and is in [pose], a direct buffer of one ml2s_pose. */
    @JvmStatic
    external fun colorPose(handle: Long, deviceNanos: Long, pose: ByteBuffer): Boolean

    /** In Hz, of an open depth camera. */
    @JvmStatic
    external fun listRates(handle: Long): IntArray

    /** A failure of the device is logged: the handle is closed in any case. */
    @JvmStatic
    external fun close(handle: Long)

    /** Slots of [stream] until [retire], whose memory is mapped when frames need it. See native/sources/slots.h. */
    @JvmStatic
    external fun reserve(stream: Int)

    @JvmStatic
    external fun retire(stream: Int)

    /** A free slot to write a frame of [sizeBytes] into; [NativeFrame.NO_SLOT] when all are leased. */
    @JvmStatic
    external fun take(stream: Int, sizeBytes: Int): Int

    /** Part of a leased slot, which must not be touched after the lease. */
    @JvmStatic
    external fun bytes(stream: Int, slot: Int, offset: Int, sizeBytes: Int): ByteBuffer

    /** Memory outside of Java's heap, until [unmap]; null when the system has none. */
    @JvmStatic
    external fun map(sizeBytes: Int): ByteBuffer?

    /** Ends the whole of a [buffer] of [map], which must not be touched any more. */
    @JvmStatic
    external fun unmap(buffer: ByteBuffer)

    /** What is mapped now: slots, buffers of [map], and what OpenXR's frames pass through. */
    @JvmStatic
    external fun mappedBytes(): Long

    /** Number [index] of the ml2s_frame in [frames], a direct buffer. */
    @JvmStatic
    external fun publish(frames: ByteBuffer, index: Int)

    @JvmStatic
    external fun unpublish(stream: Int)

    @JvmStatic
    external fun release(stream: Int, slot: Int)

    @JvmStatic
    external fun useOpenXr(loaderPath: String, context: Any?)
}
