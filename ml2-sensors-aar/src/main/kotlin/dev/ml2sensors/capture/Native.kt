package dev.ml2sensors.capture

import java.nio.ByteBuffer

/**
 * The functions of native/sdk/ml2s.h, which documents threads, ownership and units. JNI_OnLoad of libml2sensors.so,
 * which [NativeLibrary] loads, registers them.
 *
 * An error of ml2s.h is thrown as [CaptureException]. A closed handle, or one of another thread, throws
 * IllegalStateException; other misuse throws IllegalArgumentException.
 */
internal object Native {
    external fun now(): Long

    external fun boottimeOf(deviceNanos: Long): Long

    /** Returns the size of ml2s_frame and the offsets of its fields, in the order in which [FrameBlock] reads them. */
    external fun frameLayout(): IntArray

    /** Returns those of ml2s_reading, in the order in which [ReadingBlock] reads them. */
    external fun readingLayout(): IntArray

    /** Returns those of ml2s_settings, in the order in which [NativeSettings] reads them. */
    external fun settingsLayout(): IntArray

    external fun check(sensor: Int, backend: Int)

    /** Opens the sensor of the ml2s_settings in [settings], a direct buffer; returns its handle. */
    external fun open(settings: ByteBuffer): Long

    /** Changes the streams of [handle] to those of the ml2s_settings in [settings], a direct buffer. */
    external fun configure(handle: Long, settings: ByteBuffer)

    /**
     * Waits for frames and fills the ml2s_frames in [frames], a direct buffer. Returns how many were filled; 0 after
     * the timeout.
     */
    external fun poll(handle: Long, timeoutNanos: Long, frames: ByteBuffer): Int

    /** Fills the ml2s_readings in [readings], a direct buffer. Returns how many were filled. */
    external fun pollReadings(handle: Long, readings: ByteBuffer): Int

    /** Fills [pose], a direct buffer of one ml2s_reading. Returns true if the pose was known. */
    external fun colorPose(handle: Long, deviceNanos: Long, pose: ByteBuffer): Boolean

    /** Returns the rates in Hz that an open depth camera offers. */
    external fun listRates(handle: Long): IntArray

    /** Closes the handle in any case; a failure of the device is logged. */
    external fun close(handle: Long)

    /** Reserves the slots of [stream] until [retire]. Their memory is mapped when frames need it. */
    external fun reserve(stream: Int)

    external fun retire(stream: Int)

    /** Takes a free slot for a frame of [sizeBytes]; returns [NativeFrame.NO_SLOT] if all are leased. */
    external fun take(stream: Int, sizeBytes: Int): Int

    /** Returns part of a leased slot. It must not be used after the lease. */
    external fun bytes(stream: Int, slot: Int, offset: Int, sizeBytes: Int): ByteBuffer

    /** Returns how many bytes are mapped now: slots, and buffers for OpenXR's frames. */
    external fun mappedBytes(): Long

    /** Publishes ml2s_frame [index] in [frames], a direct buffer. */
    external fun publish(frames: ByteBuffer, index: Int)

    external fun unpublish(stream: Int)

    external fun release(stream: Int, slot: Int)

    /** Opens a queue of the newest [depth] messages, of Kotlin for C# or of C# for Kotlin; returns its number. */
    external fun openInbox(depth: Int): Int

    /** Copies a message into an inbox. Returns false if it is closed, or if there is no memory. */
    external fun addMessage(
        inbox: Int,
        bytes: ByteArray,
        offset: Int,
        sizeBytes: Int,
        publishedNanos: Long,
        number: Int,
    ): Boolean

    /**
     * Waits for a message in an inbox, and leases it until [releaseMessage]. Returns its bytes, or null once the inbox is
     * closed. [about] gets its slot, time and number, and how many messages newer ones have replaced so far.
     */
    external fun awaitMessage(inbox: Int, about: LongArray): ByteBuffer?

    external fun releaseMessage(inbox: Int, slot: Int)

    external fun closeInbox(inbox: Int)

    /** Returns a size in bytes that no image exceeds when [codec] compresses it, whatever it shows. */
    external fun mostEncodedBytes(codec: Int, width: Int, height: Int): Int

    /**
     * Compresses the pixels of [image], a direct buffer, into a leased slot, which has
     * at least [mostEncodedBytes]. Returns the size in bytes.
     */
    external fun encode(
        image: ByteBuffer,
        codec: Int,
        quality: Int,
        width: Int,
        height: Int,
        strideBytes: Int,
        stream: Int,
        slot: Int,
    ): Int

    external fun useOpenXr(loaderPath: String, context: Any?)
}
