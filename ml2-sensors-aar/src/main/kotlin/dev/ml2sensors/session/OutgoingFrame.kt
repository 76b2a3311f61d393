package dev.ml2sensors.session

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import java.nio.ByteBuffer

/**
 * One DATA frame between production and socket. [sent] or [drop] is called exactly once; either releases the image.
 *
 * @property head header and the first bytes of the payload.
 * @property data the rest of the payload, in memory of [sample].
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
