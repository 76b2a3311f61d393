package dev.ml2sensors.pairing

import dev.ml2sensors.link.Fingerprint
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ProtocolException
import kotlinx.serialization.Serializable
import java.io.File
import java.io.IOException

/** The receivers a device is paired with, in a JSON [file]. */
internal class ReceiverStore(private val file: File) {
    @Serializable
    private class Content(val receivers: List<Row>)

    @Serializable
    private class Row(val name: String, val fingerprint: String, val host: String, val port: Int) {
        /** Misuse in a file is a damaged file. */
        fun toReceiver() = Fingerprint(fingerprint).let { PairedReceiver(name, it, ReceiverAddress(host, port, it)) }
    }

    /** @throws IOException when the file cannot be read or is damaged. */
    fun load(): List<PairedReceiver> {
        if (!file.exists()) return emptyList()
        val content = file.readBytes()
        try {
            return ControlJson.decode<Content>(content).receivers.map(Row::toReceiver)
        } catch (e: ProtocolException) {
            throw damaged(e)
        } catch (e: IllegalArgumentException) {
            throw damaged(e)
        }
    }

    private fun damaged(cause: Exception) = IOException(
        "$file is damaged, pair again without it: ${cause.message}",
        cause,
    )

    /** In place of what was known of the same one. */
    @Synchronized
    fun add(receiver: PairedReceiver) {
        val rows = (load().filter { it.fingerprint != receiver.fingerprint } + receiver)
            .map { Row(it.name, it.fingerprint.hex, it.address.host, it.address.port) }
        val written = File.createTempFile(file.name, null, file.absoluteFile.parentFile)
        written.writeBytes(ControlJson.encode(Content(rows)))
        if (!written.renameTo(file)) {
            written.delete()
            throw IOException("cannot write $file")
        }
    }
}
