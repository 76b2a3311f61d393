package dev.ml2sensors.benchmark

import com.sun.management.ThreadMXBean
import dev.ml2sensors.transport.PlaintextChannel
import dev.ml2sensors.transport.TlsClient
import dev.ml2sensors.transport.TransportChannel
import dev.ml2sensors.wire.FrameHeader
import dev.ml2sensors.wire.FrameWriter
import kotlinx.serialization.json.JsonObjectBuilder
import kotlinx.serialization.json.buildJsonObject
import kotlinx.serialization.json.put
import org.conscrypt.Conscrypt
import java.io.File
import java.lang.management.ManagementFactory
import java.nio.ByteBuffer

/**
 * Writes a raw world camera image to a loopback socket in plaintext and by TLS, in turns; what goes out of it is read
 * and not decrypted, so the sender alone is measured. The median round goes as JSON to the file named by the argument.
 */
public fun main(args: Array<String>) {
    val keys = ServerKeys()
    val ways = mapOf<String, (LoopbackSink) -> TransportChannel>(
        "plaintext" to { PlaintextChannel(it.channel) },
        "tls" to { keys.secure(it, TlsClient(null, setOf(keys.fingerprint))) },
        "tls_android" to { keys.secure(it, TlsClient(null, setOf(keys.fingerprint), Conscrypt.newProvider())) },
    )
    val rounds = (0..ROUNDS).map { ways.mapValues { (_, open) -> measure(open) } }.drop(1)
    val report = buildJsonObject {
        put("frame", "$FRAME_BYTES bytes")
        for (way in ways.keys) report(way, rounds.map { it.getValue(way) })
        for (way in ways.keys - "plaintext") {
            val ratios = rounds.map { it.getValue(way).framesPerSecond / it.getValue("plaintext").framesPerSecond }
            put("${way}_ratio_to_plaintext", ratios.median())
        }
    }
    File(args.single()).writeText("$report\n")
}

private const val FRAME_BYTES = 1016 * 1016
private const val HEAD_BYTES = 160
private const val FRAMES = 300
private const val ROUNDS = 7
private val threads = ManagementFactory.getThreadMXBean() as ThreadMXBean

private class Measured(val framesPerSecond: Double, val cpuMicros: Double, val allocatedBytes: Double)

private fun measure(open: (LoopbackSink) -> TransportChannel): Measured = LoopbackSink(isRead = false).use { sink ->
    val channel = open(sink)
    sink.drain()
    val writer = FrameWriter(channel) { System.nanoTime() }
    val head = ByteBuffer.allocateDirect(HEAD_BYTES)
    FrameHeader(kindCode = 16, length = FRAME_BYTES + HEAD_BYTES - FrameHeader.BYTES).writeTo(head)
    val pixels = ByteBuffer.allocateDirect(FRAME_BYTES)
    val allocated = threads.currentThreadAllocatedBytes
    val cpuNanos = threads.currentThreadCpuTime
    val begin = System.nanoTime()
    repeat(FRAMES) { writer.write(head.clear(), pixels.clear()) }
    Measured(
        FRAMES * 1e9 / (System.nanoTime() - begin),
        (threads.currentThreadCpuTime - cpuNanos) / 1e3 / FRAMES,
        (threads.currentThreadAllocatedBytes - allocated).toDouble() / FRAMES,
    ).also { channel.close() }
}

private fun JsonObjectBuilder.report(way: String, rounds: List<Measured>) {
    put("${way}_frames_per_s", rounds.map { it.framesPerSecond }.median())
    put("${way}_cpu_us_per_frame", rounds.map { it.cpuMicros }.median())
    put("${way}_alloc_bytes_per_frame", rounds.map { it.allocatedBytes }.median())
}

private fun List<Double>.median() = sorted()[size / 2]
