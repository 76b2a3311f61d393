package dev.ml2sensors.clock

import dev.ml2sensors.report
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.random.Random
import kotlin.test.assertTrue

/** Compares stamps with the truth, and with their claimed uncertainty, over a minute with a step in its middle. */
class ClockScenarioTest {
    @Test
    fun stampsAreAsTrueAsIsClaimedOnEveryNetwork() {
        val results = VirtualNetwork.all.flatMap { network ->
            listOf(0, 50, -50).flatMap { ppm -> listOf(0L, 1L, -1L).map { play(network(Random(7)), ppm, it) } }
        }
        report("clock.json", results)
        for (it in results) {
            assertTrue(it.coverage >= 0.99, "$it: within the claim")
            assertTrue(it.detectionSeconds <= 1.0, "$it: the step is seen")
            if (it.scenario == "idle") assertTrue(it.p99ErrorSeconds < 20e-6, "$it: p99")
            if (it.scenario == "idle") assertTrue(it.claimedSeconds < 50e-6 + 50e-6, "$it: half a round trip and 50 us")
            if (it.scenario.startsWith("uniform")) assertTrue(it.p99ErrorSeconds < 0.2e-3, "$it: p99")
            if (it.cannotBeSeen == null) assertTrue(it.p99ErrorSeconds < 0.6e-3, "$it: p99")
            // With a round trip of 2 ms, and of 4 ms where it is asymmetric
            assertTrue(it.claimedSeconds < 2.5e-3, "$it: not uselessly wide")
        }
    }

    private fun play(network: VirtualNetwork, ppm: Int, stepSeconds: Long): ScenarioResult {
        val begin = 1_000 * SECOND
        val stepAt = begin + 30 * SECOND
        val offset = { at: Long -> OFFSET + at / 1_000_000 * ppm + if (at >= stepAt) stepSeconds * SECOND else 0 }
        val time = VirtualTime(network, offset)
        var converged = begin + CONVERGENCE
        var detected = if (stepSeconds == 0L) stepAt else Long.MAX_VALUE
        val errors = ArrayList<Double>()
        val claims = ArrayList<Double>()
        var covered = 0
        time.run(begin + 60 * SECOND) { at ->
            val status = time.clock.status
            if (status.steps > 0 && detected == Long.MAX_VALUE) {
                detected = at
                converged = at + CONVERGENCE
            }
            val stamp = time.clock.stamps.stampNanos(at)
            if (stamp == null || at < converged || at in stepAt..<detected) return@run
            val error = abs(stamp - at - offset(at))
            errors += error * 1e-9
            claims += status.uncertaintyNanos * 1e-9
            if (error <= status.uncertaintyNanos) covered++
        }
        return ScenarioResult(
            network.name,
            ppm,
            stepSeconds,
            errors.max(),
            errors.quantile(0.99),
            claims.quantile(0.5),
            claims.quantile(0.5) / errors.quantile(0.5),
            covered.toDouble() / errors.size,
            (detected - stepAt) * 1e-9,
            "half the asymmetry, 1 ms".takeIf { network.name.startsWith("asymmetric") },
        )
    }

    private companion object {
        const val OFFSET = 1_700_000_000 * SECOND
        const val CONVERGENCE = 2 * SECOND

        fun List<Double>.quantile(part: Double): Double = sorted()[((size - 1) * part).toInt()]
    }
}

/** A row of build/reports/clock.json; errors after convergence, without what was captured before a step was seen. */
@Serializable
private data class ScenarioResult(
    val scenario: String,
    @SerialName("skew_ppm") val skewPpm: Int,
    @SerialName("step_s") val stepSeconds: Long,
    @SerialName("max_error_s") val maxErrorSeconds: Double,
    @SerialName("p99_error_s") val p99ErrorSeconds: Double,
    @SerialName("claimed_s") val claimedSeconds: Double,
    @SerialName("claimed_over_true") val claimedOverTrue: Double,
    val coverage: Double,
    @SerialName("detection_s") val detectionSeconds: Double,
    @SerialName("cannot_be_seen") val cannotBeSeen: String?,
)
