package dev.ml2sensors.benchmark

import dev.ml2sensors.cdr.ByteSequenceSerializer
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Time
import kotlinx.serialization.Serializable
import kotlinx.serialization.builtins.ByteArraySerializer
import kotlinx.serialization.json.buildJsonObject
import kotlinx.serialization.json.put
import org.openjdk.jmh.annotations.Benchmark
import org.openjdk.jmh.annotations.Level
import org.openjdk.jmh.annotations.Scope
import org.openjdk.jmh.annotations.Setup
import org.openjdk.jmh.annotations.State
import org.openjdk.jmh.profile.GCProfiler
import org.openjdk.jmh.results.RunResult
import org.openjdk.jmh.runner.Runner
import org.openjdk.jmh.runner.options.OptionsBuilder
import org.openjdk.jmh.runner.options.TimeValue
import java.io.File
import java.nio.ByteBuffer

/**
 * Runs [SenderBenchmark] in rounds, each path once a round so that a noisy machine disturbs both, and writes the median
 * round as JSON to the file named by the first argument; then [DecoderBenchmark], for the second.
 */
public fun main(args: Array<String>) {
    val (sender, decoder) = args
    measureSender(File(sender))
    measureDecoder(File(decoder))
}

private fun measureSender(file: File) {
    val rounds = List(ROUNDS) { measure() }.sortedBy(Round::ratio)
    val median = rounds[ROUNDS / 2]
    val report = buildJsonObject {
        put("frame", "1016x1016 mono8")
        put("frames_per_s", median.ours.score)
        put("bare_frames_per_s", median.bare.score)
        put("ratio_to_bare", median.ratio)
        put("ratio_to_bare_lowest", rounds.first().ratio)
        put("ratio_to_bare_highest", rounds.last().ratio)
        put("alloc_bytes_per_frame", median.ours.allocatedBytes)
    }
    file.writeText("$report\n")
}

private fun measureDecoder(file: File) {
    val report = buildJsonObject {
        put("message", "sensor_msgs/msg/PointCloud2 with ${DecoderBenchmark.POINT_BYTES} bytes of points")
        for ((name, result) in run(DecoderBenchmark::class.java)) {
            put("${name}_us", MICROS_PER_SECOND / result.score)
            put("${name}_alloc_bytes", result.allocatedBytes)
        }
    }
    file.writeText("$report\n")
}

private const val ROUNDS = 7
private const val MICROS_PER_SECOND = 1e6

private class Round(val ours: RunResult, val bare: RunResult) {
    val ratio: Double get() = ours.score / bare.score
}

private fun measure(): Round = run(SenderBenchmark::class.java).let {
    Round(it.getValue("encodeAndWrite"), it.getValue("bareWrite"))
}

/** Runs each benchmark of a class; returns the results by name. */
private fun run(benchmarks: Class<*>): Map<String, RunResult> {
    val options = OptionsBuilder()
        .include(benchmarks.simpleName)
        .addProfiler(GCProfiler::class.java)
        .forks(1)
        .warmupIterations(1)
        .warmupTime(TimeValue.seconds(1))
        .measurementIterations(2)
        .measurementTime(TimeValue.seconds(1))
        .build()
    return Runner(options).run().associateBy { it.params.benchmark.substringAfterLast('.') }
}

private val RunResult.score: Double get() = primaryResult.score

private val RunResult.allocatedBytes: Double get() = secondaryResults.getValue("gc.alloc.rate.norm").score

/** Decodes a point cloud whose points are a view of the bytes received, or a copy of them. */
@State(Scope.Thread)
public open class DecoderBenchmark {
    private lateinit var bytes: ByteBuffer

    @Setup(Level.Trial)
    public fun encode() {
        val header = Header(Time.ofNanos(1), "lidar")
        val fields = List(4) { PointField("xyzi"[it].toString(), 4u * it.toUInt(), FLOAT32, 1u) }
        val count = (POINT_BYTES / POINT_STEP).toUInt()
        val points = ByteArray(POINT_BYTES)
        val cloud =
            PointCloud(header, 1u, count, fields, false, POINT_STEP.toUInt(), points.size.toUInt(), points, true)
        bytes = ByteBuffer.wrap(Cdr.encodeToByteArray(COPIED, cloud))
    }

    @Benchmark
    public fun view(): Any = Cdr.decode(VIEWED, bytes, allowsTail = true)

    @Benchmark
    public fun copy(): Any = Cdr.decode(COPIED, bytes, allowsTail = true)

    internal companion object {
        const val POINT_BYTES = 1 shl 20
        private const val POINT_STEP = 16
        private const val FLOAT32: UByte = 7u
        private val VIEWED = PointCloud.serializer(ByteSequenceSerializer)
        private val COPIED = PointCloud.serializer(ByteArraySerializer())
    }
}

@Serializable
private class PointField(val name: String, val offset: UInt, val datatype: UByte, val count: UInt)

@Serializable
private class PointCloud<T>(
    val header: Header,
    val height: UInt,
    val width: UInt,
    val fields: List<PointField>,
    val isBigendian: Boolean,
    val pointStep: UInt,
    val rowStep: UInt,
    val data: T,
    val isDense: Boolean,
)
