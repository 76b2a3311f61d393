package dev.ml2sensors.app.screen

import dev.ml2sensors.app.status.StreamStatus

/** Messages per second between one call and the next. Not thread-safe. */
internal class Rates {
    private var before = emptyMap<String, Long>()
    private var beforeMillis = 0L

    /** In Hz, by stream id; of those streams that were there before. */
    fun of(streams: List<StreamStatus>, nowMillis: Long): Map<String, Double> {
        val produced = streams.associate { it.id to it.produced }
        val seconds = (nowMillis - beforeMillis) / 1e3
        val rates = produced.filter { (id, count) -> seconds > 0 && count >= (before[id] ?: Long.MAX_VALUE) }
            .mapValues { (id, count) -> (count - before.getValue(id)) / seconds }
        before = produced
        beforeMillis = nowMillis
        return rates
    }
}
