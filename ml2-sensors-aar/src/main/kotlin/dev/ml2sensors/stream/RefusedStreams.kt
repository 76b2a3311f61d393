package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.delay
import kotlin.time.Duration.Companion.seconds

private val RECHECK_INTERVAL = 1.seconds

/**
 * Asks again once a second for [refused] streams, which a new permission may allow, until it is cancelled. [report]
 * gets the ids of those that would be accepted: they are `available` in STATUS, and the receiver configures again.
 */
internal suspend fun Headset.recheck(refused: Map<String, StreamValues>, report: (Set<String>) -> Unit) {
    val known = refused.mapNotNull { (id, values) -> StreamTable.byId(id)?.let { it to values } }
    while (known.isNotEmpty()) {
        delay(RECHECK_INTERVAL)
        val accepted = known.filter { (stream, values) -> negotiate(stream, values) !is Answer.Refused }
        report(accepted.map { (stream) -> stream.id }.toSet())
    }
}
