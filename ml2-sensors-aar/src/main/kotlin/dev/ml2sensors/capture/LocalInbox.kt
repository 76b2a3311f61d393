package dev.ml2sensors.capture

import java.nio.ByteBuffer

/** A queue of the newest messages for a native reader in the same process, until [close]. Thread-safe. */
internal class LocalInbox(depth: Int) {
    /** The inbox of `ml2s_inbox_acquire`. */
    val number: Int = openInbox(depth)

    /** Copies a message, a buffer on the heap. Returns false if this is closed, or if there is no memory. */
    fun add(message: ByteBuffer, publishedNanos: Long, number: Int): Boolean {
        val offset = message.arrayOffset() + message.position()
        return Native.addMessage(this.number, message.array(), offset, message.remaining(), publishedNanos, number)
    }

    fun close(): Unit = Native.closeInbox(number)
}

/** A queue of the newest messages of a native writer in the same process, until [close]. Thread-safe. */
internal class LocalOutbox(depth: Int) {
    /** One message: [bytes] are valid until the call with it returns. [lost] others were replaced by newer ones before. */
    class Message(val bytes: ByteBuffer, val nanos: Long, val number: Int, val lost: Int)

    /** The inbox of `ml2s_inbox_add`. */
    val number: Int = openInbox(depth)

    /** Waits for messages and passes each to [take], on the calling thread, until [close]. */
    fun forEach(take: (Message) -> Unit) {
        val about = LongArray(ABOUT)
        var lost = 0L
        while (true) {
            val bytes = Native.awaitMessage(number, about) ?: break
            val (slot, nanos, messageNumber, leftOut) = about
            try {
                take(Message(bytes, nanos, messageNumber.toInt(), (leftOut - lost).toInt()))
            } finally {
                Native.releaseMessage(number, slot.toInt())
            }
            lost = leftOut
        }
    }

    fun close(): Unit = Native.closeInbox(number)

    private companion object {
        /** As many values as [Native.awaitMessage] has about a message. */
        const val ABOUT = 4
    }
}

private fun openInbox(depth: Int): Int {
    check(NativeLibrary.isLoaded) { "messages wait in libml2sensors.so, which is not loaded" }
    return Native.openInbox(depth)
}
