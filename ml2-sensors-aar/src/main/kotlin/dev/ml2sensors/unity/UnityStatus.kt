package dev.ml2sensors.unity

import dev.ml2sensors.pairing.PairedReceiver
import dev.ml2sensors.stream.StreamerStatus
import dev.ml2sensors.wire.Status
import kotlinx.serialization.Serializable

/** The JSON of [Ml2Unity.status]. */
@Serializable
internal data class UnityStatus(
    val state: String,
    val receiver: String,
    val reason: String,
    val insecure: Boolean = false,
    val streams: Map<String, StreamerStatus.Stream> = emptyMap(),
    val channels: Map<String, Status.ChannelCounts> = emptyMap(),
    val clock: Status.Clock? = null,
    val pairing: Pairing = Pairing(),
) {
    constructor(streamer: StreamerStatus, insecure: Boolean) : this(
        streamer.state,
        streamer.receiver,
        streamer.reason,
        insecure,
        streamer.streams,
        streamer.channels,
        streamer.clock,
    )

    @Serializable
    class Receiver(val name: String, val fingerprint: String, val address: String) {
        constructor(paired: PairedReceiver) :
            this(paired.name, paired.fingerprint.hex, "${paired.address}")
    }

    /** The result of the last of [number] pairings, and the receivers that this app is paired with. */
    @Serializable
    data class Pairing(
        val number: Int = 0,
        val state: String = "none",
        val reason: String = "",
        val receivers: List<Receiver> = emptyList(),
    )
}
