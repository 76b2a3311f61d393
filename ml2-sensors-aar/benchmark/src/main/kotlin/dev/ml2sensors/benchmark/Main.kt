package dev.ml2sensors.benchmark

import kotlinx.serialization.json.buildJsonObject
import kotlinx.serialization.json.put
import org.openjdk.jmh.profile.GCProfiler
import org.openjdk.jmh.results.RunResult
import org.openjdk.jmh.runner.Runner
import org.openjdk.jmh.runner.options.OptionsBuilder
import org.openjdk.jmh.runner.options.TimeValue
import java.io.File

/**
 * Runs [SenderBenchmark] in rounds, each path once a round so that a noisy machine disturbs both, and writes the median
 * round as JSON to the file named by the one argument.
 */
public fun main(args: Array<String>) {
    val rounds = List(ROUNDS) { measure() }.sortedBy(Round::ratio)
    val median = rounds[ROUNDS / 2]
    val report = buildJsonObject {
        put("frame", "1016x1016 mono8")
        put("frames_per_s", median.ours.score)
        put("bare_frames_per_s", median.bare.score)
        put("ratio_to_bare", median.ratio)
        put("ratio_to_bare_lowest", rounds.first().ratio)
        put("ratio_to_bare_highest", rounds.last().ratio)
        put("alloc_bytes_per_frame", median.ours.secondaryResults.getValue("gc.alloc.rate.norm").score)
    }
    File(args.single()).writeText("$report\n")
}

private const val ROUNDS = 7

private class Round(val ours: RunResult, val bare: RunResult) {
    val ratio: Double get() = ours.score / bare.score
}

private fun measure(): Round {
    val options = OptionsBuilder()
        .include(SenderBenchmark::class.java.simpleName)
        .addProfiler(GCProfiler::class.java)
        .forks(1)
        .warmupIterations(1)
        .warmupTime(TimeValue.seconds(1))
        .measurementIterations(2)
        .measurementTime(TimeValue.seconds(1))
        .build()
    val results = Runner(options).run().associateBy { it.params.benchmark.substringAfterLast('.') }
    return Round(results.getValue("encodeAndWrite"), results.getValue("bareWrite"))
}

private val RunResult.score: Double get() = primaryResult.score
