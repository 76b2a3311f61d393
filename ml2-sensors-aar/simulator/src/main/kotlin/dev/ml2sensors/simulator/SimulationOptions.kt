package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.PrintMessage
import com.github.ajalt.clikt.core.UsageError
import com.github.ajalt.clikt.parameters.groups.OptionGroup
import com.github.ajalt.clikt.parameters.options.convert
import com.github.ajalt.clikt.parameters.options.multiple
import com.github.ajalt.clikt.parameters.options.option
import dev.ml2sensors.simulator.simulated.AndroidOtherwise
import dev.ml2sensors.simulator.simulated.NativeBundle
import dev.ml2sensors.simulator.simulated.SimulationKey
import dev.ml2sensors.simulator.simulated.SimulationSetting
import dev.ml2sensors.simulator.simulated.randomFaults
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.launch
import kotlin.concurrent.thread
import kotlin.time.Duration
import kotlin.time.TimeSource

/** The option `--simulate`: keys of the simulated device, set at the start or later. */
internal class SimulationOptions : OptionGroup() {
    private val simulate by option(
        metavar = "KEY=VALUE[@S]",
        help = "Set a key of the simulated device, at the start or S seconds after the first sample; repeatable. " +
            "- takes lines KEY=VALUE from standard input after it. harsh=SEED sets faults at random, until @S. " +
            "help lists all keys.",
    )
        .convert {
            val setting = COMMANDS.find { command -> command.key == it } ?: SimulationSetting.parse(it)
            setting ?: fail("expected KEY=VALUE or KEY=VALUE@SECONDS, found '$it'")
        }
        .multiple()

    val isGiven: Boolean get() = simulate.isNotEmpty()
    val isReading: Boolean get() = INPUT in simulate

    private val settings get() = simulate.filter { it != INPUT && it.key != HARSH }
    private val harsh get() = simulate.lastOrNull { it.key == HARSH }

    private fun SimulationSetting.seed(): Long = value.toLongOrNull()
        ?: throw UsageError("expected $HARSH=SEED with a whole number, found '$this'")

    /** @param cacheFolder keeps rendered frames for later runs; empty for none. */
    fun open(seed: Long, cacheFolder: String): SimulatedHeadset {
        if (HELP in simulate) throw PrintMessage(describeKeys())
        harsh?.seed()
        val atOnce = settings.filter { it.after == null }.associate { it.key to it.value }
        return asUsageErrors { SimulatedHeadset.open(seed, mapOf("cache" to cacheFolder) + atOnce) }
    }

    /** Sets all later settings, timed from this call. */
    suspend fun setLater(headset: SimulatedHeadset, log: (String) -> Unit): Unit = coroutineScope {
        if (isReading) thread(isDaemon = true) { headset.setAsRead(log) }
        val randomFaults = harsh?.run { randomFaults(seed(), SimulationKey.all(), after ?: Duration.INFINITE) }
        for (timeline in settings.filter { it.after != null }.map { sequenceOf(it) } + randomFaults.orEmpty()) {
            launch { headset.setOnSchedule(timeline, log) }
        }
    }

    private companion object {
        const val HARSH = "harsh"
        val HELP = SimulationSetting("help", "")
        val INPUT = SimulationSetting("-", "")
        val COMMANDS = listOf(HELP, INPUT)
    }
}

/** Sets each of [settings], which are in order of time, when it is due. */
private suspend fun SimulatedHeadset.setOnSchedule(settings: Sequence<SimulationSetting>, log: (String) -> Unit) {
    val begin = TimeSource.Monotonic.markNow()
    for (setting in settings) {
        delay(setting.after!! - begin.elapsedNow())
        asUsageErrors { set(setting.key, setting.value) }
        log("simulating $setting")
    }
}

/** Sets what the lines of standard input say, as they come; logs those that are wrong. */
private fun SimulatedHeadset.setAsRead(log: (String) -> Unit) {
    for (line in generateSequence(::readlnOrNull)) {
        try {
            val setting = requireNotNull(SimulationSetting.parse(line)) { "expected KEY=VALUE, found '$line'" }
            set(setting.key, setting.value)
            log("simulating $setting")
        } catch (mistake: IllegalArgumentException) {
            log("the simulated device: ${mistake.message}")
        }
    }
}

private fun describeKeys(): String {
    NativeBundle.load()
    val keys = SimulationKey.all() + SimulationKey.silent + AndroidOtherwise.entries.map { it.key }
    return keys.joinToString("\n") { "${it.name}=${it.default}  ${it.meaning}${it.describeRange()}" }
}

private fun SimulationKey.describeRange(): String = when {
    choices.isNotEmpty() -> choices.joinToString(prefix = " (", postfix = ")") { choice -> choice.ifEmpty { "none" } }
    isText -> ""
    isWhole -> " (${range.start.toLong()} to ${range.endInclusive.toLong()})"
    else -> " (${range.start} to ${range.endInclusive})"
}

private inline fun <T> asUsageErrors(action: () -> T): T = try {
    action()
} catch (mistake: IllegalArgumentException) {
    throw UsageError("the simulated device: ${mistake.message} (--simulate help lists all keys)")
}
