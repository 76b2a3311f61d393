package dev.ml2sensors.app.screen

/** Measures messages per second between two calls. Not thread-safe. */
internal class RateMeter {
    private var before = emptyMap<String, Long>()
    private var beforeMillis = 0L

    /** Returns rates in Hz by name, for the names that were in the last call, too. */
    fun update(counts: Map<String, Long>, nowMillis: Long): Map<String, Double> {
        val seconds = (nowMillis - beforeMillis) / 1e3
        val rates = counts.filter { (id, count) -> seconds > 0 && count >= (before[id] ?: Long.MAX_VALUE) }
            .mapValues { (id, count) -> (count - before.getValue(id)) / seconds }
        before = counts
        beforeMillis = nowMillis
        return rates
    }
}
