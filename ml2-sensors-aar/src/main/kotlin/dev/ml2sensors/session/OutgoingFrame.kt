package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import java.nio.ByteBuffer

/**
 * One DATA frame between production and socket. Exactly one of [sent] and [drop] is called, once; either gives back the
 * borrowed memory.
 *
 * @property head header and the first bytes of the payload.
 * @property data the rest of the payload, in memory borrowed from [sample].
 */
internal class OutgoingFrame(
    private val counters: ChannelCounters,
    val head: ByteBuffer,
    val data: ByteBuffer?,
    private val sample: ImageSample?,
) {
    fun sent() {
        counters.countSent()
        sample?.release()
    }

    fun drop(reason: DropReason) {
        counters.countDropped(reason)
        sample?.release()
    }
}
