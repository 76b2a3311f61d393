package dev.ml2sensors.pairing

import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.transport.Fingerprint
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.ProtocolException
import kotlinx.serialization.Serializable
import java.io.File
import java.io.IOException

/** Stores the paired receivers of a device in a JSON [file]. Thread-safe; for one process. */
internal class ReceiverStore(private val file: File) {
    @Serializable
    private class Content(val receivers: List<Row>)

    @Serializable
    private class Row(val name: String, val fingerprint: String, val host: String, val port: Int) {
        /** Throws IllegalArgumentException for values that are not legal, which means a damaged file. */
        fun toReceiver() = Fingerprint(fingerprint).let { PairedReceiver(name, it, ReceiverAddress(host, port, it)) }
    }

    private class DamagedException(message: String, cause: Exception) : IOException(message, cause)

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

    private fun damaged(cause: Exception) =
        DamagedException("$file is damaged; run ml2-receiver pair, which replaces it: ${cause.message}", cause)

    /** Adds [receiver], replacing an entry with the same fingerprint, or a damaged file. */
    fun add(receiver: PairedReceiver): Unit = synchronized(WRITING) {
        val known = try {
            load()
        } catch (_: DamagedException) {
            emptyList() // Which load has told whoever wanted to know them
        }
        val rows = (known.filter { it.fingerprint != receiver.fingerprint } + receiver)
            .map { Row(it.name, it.fingerprint.hex, it.address.host, it.address.port) }
        write(ControlJson.encode(Content(rows)))
    }

    /** Replaces the file atomically, also when the power fails. */
    private fun write(content: ByteArray) {
        val written = File.createTempFile(file.name, null, file.absoluteFile.parentFile)
        try {
            written.outputStream().use {
                it.write(content)
                it.fd.sync()
            }
            if (!written.renameTo(file)) throw IOException("cannot write $file")
        } finally {
            written.delete() // Nothing is left of that name when all went well
        }
    }

    private companion object {
        /** One lock for all stores, since several may have the same file. */
        val WRITING = Any()
    }
}
