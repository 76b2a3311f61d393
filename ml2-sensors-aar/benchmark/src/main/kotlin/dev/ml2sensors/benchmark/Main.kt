package dev.ml2sensors.benchmark

import kotlinx.serialization.json.buildJsonObject
import kotlinx.serialization.json.put
import org.openjdk.jmh.profile.GCProfiler
import org.openjdk.jmh.results.RunResult
import org.openjdk.jmh.runner.Runner
import org.openjdk.jmh.runner.options.OptionsBuilder
import org.openjdk.jmh.runner.options.TimeValue
import java.io.File

/** Runs [SenderBenchmark] and writes its ratios as JSON to the file named by the one argument. */
public fun main(args: Array<String>) {
    val options = OptionsBuilder()
        .include(SenderBenchmark::class.java.simpleName)
        .addProfiler(GCProfiler::class.java)
        .forks(2)
        .warmupIterations(2)
        .warmupTime(TimeValue.seconds(1))
        .measurementIterations(5)
        .measurementTime(TimeValue.seconds(1))
        .build()
    val results = Runner(options).run().associateBy { it.params.benchmark.substringAfterLast('.') }
    val ours = results.getValue("encodeAndWrite")
    val bare = results.getValue("bareWrite")
    val report = buildJsonObject {
        put("frame", "1016x1016 mono8")
        put("frames_per_s", ours.score)
        put("bare_frames_per_s", bare.score)
        put("ratio_to_bare", ours.score / bare.score)
        put("alloc_bytes_per_frame", ours.secondaryResults.getValue("gc.alloc.rate.norm").score)
    }
    val file = File(args.single())
    file.absoluteFile.parentFile.mkdirs()
    file.writeText("$report\n")
    println(file.readText())
}

private val RunResult.score: Double get() = primaryResult.score
