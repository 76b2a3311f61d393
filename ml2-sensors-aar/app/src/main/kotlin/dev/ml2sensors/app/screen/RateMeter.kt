package dev.ml2sensors.app.screen

import dev.ml2sensors.app.status.StreamStatus

/** Measures messages per second between two calls. Not thread-safe. */
internal class RateMeter {
    private var before = emptyMap<String, Long>()
    private var beforeMillis = 0L

    /** Returns rates in Hz by stream id, for the streams that were in the last call, too. */
    fun update(streams: List<StreamStatus>, nowMillis: Long): Map<String, Double> {
        val produced = streams.associate { it.id to it.produced }
        val seconds = (nowMillis - beforeMillis) / 1e3
        val rates = produced.filter { (id, count) -> seconds > 0 && count >= (before[id] ?: Long.MAX_VALUE) }
            .mapValues { (id, count) -> (count - before.getValue(id)) / seconds }
        before = produced
        beforeMillis = nowMillis
        return rates
    }
}
