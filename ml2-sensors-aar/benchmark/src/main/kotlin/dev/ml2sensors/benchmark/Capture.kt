package dev.ml2sensors.benchmark

import com.sun.management.ThreadMXBean
import dev.ml2sensors.capture.NativeBackend
import dev.ml2sensors.capture.NativeLibrary
import dev.ml2sensors.capture.NativePixelSource
import dev.ml2sensors.capture.PixelSensor
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.Time
import dev.ml2sensors.session.Lane
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.stream.TopicChannel
import dev.ml2sensors.stream.toImage
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.FrameWriter
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.buildJsonObject
import kotlinx.serialization.json.put
import java.io.File
import java.lang.management.ManagementFactory
import java.nio.ByteBuffer
import java.nio.file.Path
import java.util.concurrent.locks.LockSupport

/**
 * Captures three world cameras through libml2sensors.so (its path is the first argument) over the simulated device and
 * sends them to loopback sockets; what that costs per frame, beside one copy and one gathering write of the same bytes,
 * goes as JSON to the second argument.
 */
public fun main(args: Array<String>) {
    NativeLibrary.load(Path.of(args[0]))
    capture(WARM_UP_FRAMES)
    val captured = capture(FRAMES)
    bare(WARM_UP_FRAMES)
    val bare = bare(FRAMES)
    val report = buildJsonObject {
        put("frame", "1016x1016 mono8 of each of three cameras")
        put("frames", (WARM_UP_FRAMES + FRAMES) * CAMERAS.size)
        put("payload_bytes_per_frame", SIDE * SIDE)
        put("cpu_us_per_frame", captured.cpuMicros)
        put("bare_cpu_us_per_frame", bare.cpuMicros)
        put("alloc_bytes_per_frame", captured.allocatedBytes)
    }
    File(args[1]).writeText("$report\n")
}

private const val SIDE = 1016
private const val WARM_UP_FRAMES = 60
private const val FRAMES = 300
private const val HEAD_BYTES = 128
private const val PERIOD_NANOS = 1_000_000_000L / 30
private const val SLOTS = 24
private const val FILM_FRAMES = 180
private val CAMERAS = listOf(StreamTable.worldLeft, StreamTable.worldCenter, StreamTable.worldRight)
private val threads = ManagementFactory.getThreadMXBean() as ThreadMXBean

/** The cost of one frame. */
private class Cost(val cpuMicros: Double, val allocatedBytes: Double)

/** The source's own thread works, and this one. The simulated device's copy into the frame it lends is part of it. */
private fun capture(framesPerCamera: Int): Cost {
    NativePixelSource(PixelSensor.WORLD, NativeBackend.SDK).use { source ->
        return cost(framesPerCamera * CAMERAS.size) {
            runBlocking { for (camera in CAMERAS) launch { source.send(camera, framesPerCamera) } }
        }
    }
}

private suspend fun NativePixelSource.send(camera: StreamSpec, count: Int) = LoopbackSink().use { sink ->
    val writer = FrameWriter(sink.channel) { System.nanoTime() }
    val topic = camera.topics.first()
    val channel = TopicChannel(1, topic, Lane(topic.lane, StreamTable.imageLane, suspendsWhenFull = false))
    samples(camera, camera.defaultValues()).filterIsInstance<ImageSample>().take(count).collect { sample ->
        val image = sample.toImage(Header(Time.ofNanos(1), camera.frameId), "mono8", sample.pixels)
        val frame = channel.frame(Image.serializer(), image, stampNanos = 1, sample)
        writer.write(frame.head, frame.data)
        frame.sent()
    }
}

/** As often as the cameras, and from and to as much memory, since caches are part of the cost. */
private fun bare(framesPerCamera: Int): Cost = LoopbackSink().use { sink ->
    val head = ByteBuffer.allocateDirect(HEAD_BYTES)
    val frames = List(FILM_FRAMES) { ByteBuffer.allocateDirect(SIDE * SIDE) }
    val slots = List(SLOTS) { ByteBuffer.allocateDirect(SIDE * SIDE) }
    cost(framesPerCamera * CAMERAS.size) {
        val begin = System.nanoTime()
        repeat(framesPerCamera) { tick ->
            LockSupport.parkNanos(begin + tick * PERIOD_NANOS - System.nanoTime())
            for (camera in CAMERAS.indices) {
                val number = tick * CAMERAS.size + camera
                val slot = slots[number % SLOTS]
                slot.clear().put(frames[number % FILM_FRAMES].clear()).flip()
                val pieces = arrayOf(head.rewind(), slot)
                while (slot.hasRemaining()) sink.channel.write(pieces)
            }
        }
    }
}

/** Returns the cost of [block] per frame, in this thread and those of sensors, which must outlive it. */
private fun cost(frames: Int, block: () -> Unit): Cost {
    val before = Spent.now()
    block()
    val after = Spent.now()
    return Cost(
        (after.cpuNanos - before.cpuNanos) / 1e3 / frames,
        (after.allocatedBytes - before.allocatedBytes).toDouble() / frames,
    )
}

private class Spent(val cpuNanos: Long, val allocatedBytes: Long) {
    companion object {
        fun now(): Spent {
            val sensors = threads.getThreadInfo(threads.allThreadIds).filter { it.threadName.startsWith("ml2s ") }
            return Spent(
                threads.currentThreadCpuTime + sensors.sumOf { threads.getThreadCpuTime(it.threadId) },
                threads.currentThreadAllocatedBytes + sensors.sumOf { threads.getThreadAllocatedBytes(it.threadId) },
            )
        }
    }
}
