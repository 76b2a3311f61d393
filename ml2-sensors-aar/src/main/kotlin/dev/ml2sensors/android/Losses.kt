package dev.ml2sensors.android

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.LostSamples
import java.util.EnumMap

/** What was lost and not yet told. Used by one thread. */
internal class Losses {
    private val counts = EnumMap<DropReason, Int>(DropReason::class.java)

    fun add(reason: DropReason) {
        counts[reason] = (counts[reason] ?: 0) + 1
    }

    /** Tells what is due, at [captureNanos]; what [tell] cannot take stays due. */
    inline fun tell(captureNanos: Long, tell: (LostSamples) -> Boolean) {
        if (counts.isEmpty()) return
        val due = counts.entries.iterator()
        for ((reason, count) in due) {
            if (tell(LostSamples(captureNanos, count, reason))) due.remove()
        }
    }
}
