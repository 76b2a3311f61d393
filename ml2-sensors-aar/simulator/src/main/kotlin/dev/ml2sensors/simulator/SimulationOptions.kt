package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.PrintMessage
import com.github.ajalt.clikt.core.UsageError
import com.github.ajalt.clikt.parameters.groups.OptionGroup
import com.github.ajalt.clikt.parameters.options.convert
import com.github.ajalt.clikt.parameters.options.multiple
import com.github.ajalt.clikt.parameters.options.option
import dev.ml2sensors.simulator.simulated.NativeBundle
import dev.ml2sensors.simulator.simulated.SimulatedKey
import dev.ml2sensors.simulator.simulated.SimulatedSetting
import dev.ml2sensors.simulator.simulated.drawnFaults
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.delay
import kotlinx.coroutines.launch
import kotlin.time.Duration
import kotlin.time.TimeSource

/** What is simulated, and when. */
internal class SimulationOptions : OptionGroup() {
    private val simulate by option(
        metavar = "KEY=VALUE[@S]",
        help = "Set a key of the simulated device, at once or after S seconds of samples; repeatable. " +
            "harsh=SEED sets faults at random. help lists all keys.",
    )
        .convert {
            val setting = if (it == HELP) HELPING else SimulatedSetting.parse(it)
            setting ?: fail("expected KEY=VALUE or KEY=VALUE@SECONDS, found '$it'")
        }
        .multiple()

    val isGiven: Boolean get() = simulate.isNotEmpty()

    private val harshSeed: Long?
        get() = simulate.lastOrNull { it.key == HARSH }?.run {
            value.toLongOrNull() ?: throw UsageError("expected $HARSH=SEED with a whole number, found '$this'")
        }

    /** @param films keeps drawn pictures; empty: nothing does. */
    fun open(seed: Long, films: String): SimulatedHeadset {
        if (HELPING in simulate) throw PrintMessage(describedKeys())
        harshSeed
        val atOnce = simulate.filter { it.after == null && it.key != HARSH }.associate { it.key to it.value }
        return naming { SimulatedHeadset.open(seed, mapOf("cache" to films) + atOnce) }
    }

    /** Sets what is to be set after the first sample, which is now. Faults that are drawn end before [duration] does. */
    suspend fun setLater(headset: SimulatedHeadset, duration: Duration?, say: (String) -> Unit): Unit = coroutineScope {
        val drawn = harshSeed?.let { drawnFaults(it, SimulatedKey.all(), duration) }.orEmpty()
        for (settings in simulate.filter { it.after != null }.map { sequenceOf(it) } + drawn) {
            launch { headset.setInTime(settings, say) }
        }
    }

    private companion object {
        const val HELP = "help"
        const val HARSH = "harsh"
        val HELPING = SimulatedSetting(HELP, "")
    }
}

/** Each of the [settings], which are in order of time. */
private suspend fun SimulatedHeadset.setInTime(settings: Sequence<SimulatedSetting>, say: (String) -> Unit) {
    val begin = TimeSource.Monotonic.markNow()
    for (setting in settings) {
        delay(setting.after!! - begin.elapsedNow())
        naming { set(setting.key, setting.value) }
        say("simulating $setting")
    }
}

private fun describedKeys(): String {
    NativeBundle.load()
    return SimulatedKey.all().joinToString("\n") { "${it.name}=${it.default}  ${it.meaning}${it.rangeInWords()}" }
}

private fun SimulatedKey.rangeInWords(): String = when {
    choices.isNotEmpty() -> choices.joinToString(prefix = " (", postfix = ")") { choice -> choice.ifEmpty { "none" } }
    isText -> ""
    isWhole -> " (${range.start.toLong()} to ${range.endInclusive.toLong()})"
    else -> " (${range.start} to ${range.endInclusive})"
}

private inline fun <T> naming(action: () -> T): T = try {
    action()
} catch (mistake: IllegalArgumentException) {
    throw UsageError("the simulated device: ${mistake.message} (--simulate help lists all keys)")
}
