package dev.ml2sensors.simulator.simulated

import kotlin.math.exp
import kotlin.math.ln
import kotlin.random.Random
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * Returns the faults of a harsh device, a sequence in order of time for each interface of the simulated device: the
 * vendor's SDK, and OpenXR. A stream is subject to the faults of its backend only, so each interface has its own.
 *
 * They are drawn by [seed] from all [keys] of faults. Each fault ends, by its default, after some seconds; at most
 * [MOST_AT_ONCE] of an interface are there at a time. All have ended [quietTime] before [duration] is over; without one
 * they go on for ever.
 */
internal fun drawnFaults(
    seed: Long,
    keys: List<SimulatedKey>,
    duration: Duration?,
): List<Sequence<SimulatedSetting>> = FAULTS_OF_INTERFACES.map { prefix ->
    drawn(seed, keys.filter { it.name.startsWith(prefix) && (!it.isText || it.choices.isNotEmpty()) }, duration)
}

private fun drawn(seed: Long, faults: List<SimulatedKey>, duration: Duration?): Sequence<SimulatedSetting> = sequence {
    val random = Random(seed)
    val end = duration?.let { it - quietTime(it) } ?: Duration.INFINITE
    val present = mutableListOf<SimulatedKey>()
    var time = random.pause()
    while (time < end) {
        val absent = faults - present
        if (present.size == MOST_AT_ONCE || (present.isNotEmpty() && random.nextBoolean())) {
            val key = present.removeAt(random.nextInt(present.size))
            yield(SimulatedSetting(key.name, key.default, time))
        } else {
            val key = absent.random(random).also(present::add)
            yield(SimulatedSetting(key.name, random.valueOf(key), time))
        }
        time += random.pause()
    }
    for (key in present) yield(SimulatedSetting(key.name, key.default, end))
}

/** How long a harsh device is left alone before [duration] is over, so that everything can come back. */
internal fun quietTime(duration: Duration): Duration = minOf(LONGEST_QUIET, duration * QUIET_SHARE)

private fun Random.pause(): Duration = nextDouble(SHORTEST_PAUSE_S, LONGEST_PAUSE_S).seconds

/** A choice, or a number from 1 to the most; small ones more often, since many are a count of frames. */
private fun Random.valueOf(key: SimulatedKey): String {
    if (key.isText) return (key.choices - key.default).random(this)
    val share = nextDouble()
    val value = exp(share * share * ln(key.range.endInclusive + 1)).coerceAtMost(key.range.endInclusive)
    return if (key.isWhole) "${value.toLong()}" else "$value"
}

private val FAULTS_OF_INTERFACES = listOf("fault.", "openxr.fault.")
private const val MOST_AT_ONCE = 2
private const val SHORTEST_PAUSE_S = 0.3
private const val LONGEST_PAUSE_S = 2.0
private const val QUIET_SHARE = 0.4
private val LONGEST_QUIET = 75.seconds
