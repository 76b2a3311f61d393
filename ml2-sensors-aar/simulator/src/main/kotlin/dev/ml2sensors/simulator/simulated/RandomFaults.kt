package dev.ml2sensors.simulator.simulated

import kotlin.math.exp
import kotlin.math.ln
import kotlin.random.Random
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * Returns the random faults of each interface of the simulated device, the vendor's SDK and OpenXR, in order of time. A
 * stream is subject to the faults of its backend only, so each interface has its own.
 *
 * The faults are chosen by [seed] from the [keys] of faults. Each fault ends after some seconds, when its key gets its
 * default again. At most [MAX_CONCURRENT] faults of an interface are active at a time. All faults have ended after
 * [duration].
 */
internal fun randomFaults(
    seed: Long,
    keys: List<SimulationKey>,
    duration: Duration,
): List<Sequence<SimulationSetting>> = INTERFACE_PREFIXES.map { prefix ->
    timeline(seed, keys.filter { it.name.startsWith(prefix) && (!it.isText || it.choices.isNotEmpty()) }, duration)
}

private fun timeline(
    seed: Long,
    faults: List<SimulationKey>,
    duration: Duration,
): Sequence<SimulationSetting> = sequence {
    val random = Random(seed)
    val active = mutableListOf<SimulationKey>()
    var time = random.pause()
    while (time < duration) {
        val inactive = faults - active
        if (active.size == MAX_CONCURRENT || (active.isNotEmpty() && random.nextBoolean())) {
            val key = active.removeAt(random.nextInt(active.size))
            yield(SimulationSetting(key.name, key.default, time))
        } else {
            val key = inactive.random(random).also(active::add)
            yield(SimulationSetting(key.name, random.valueOf(key), time))
        }
        time += random.pause()
    }
    for (key in active) yield(SimulationSetting(key.name, key.default, duration))
}

private fun Random.pause(): Duration = nextDouble(MIN_PAUSE_S, MAX_PAUSE_S).seconds

/**
 * Returns a choice, or a number from 1 to the largest allowed. Small numbers are more frequent, since many faults count
 * frames.
 */
private fun Random.valueOf(key: SimulationKey): String {
    if (key.isText) return (key.choices - key.default).random(this)
    val share = nextDouble()
    val value = exp(share * share * ln(key.range.endInclusive + 1)).coerceAtMost(key.range.endInclusive)
    return if (key.isWhole) "${value.toLong()}" else "$value"
}

private val INTERFACE_PREFIXES = listOf("fault.", "openxr.fault.")
private const val MAX_CONCURRENT = 2
private const val MIN_PAUSE_S = 0.3
private const val MAX_PAUSE_S = 2.0
