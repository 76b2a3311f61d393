package dev.ml2sensors.android

/**
 * Pairs images and results of the same timestamp. Each kind arrives in order; either may arrive first, and some are
 * missing. An image is unmatched when a later result arrives. Used by one thread.
 *
 * @param unmatched receives each unmatched image. A result without an image is a frame that the device dropped.
 */
internal class TimestampMatch<I, R>(private val pair: (I, R) -> Unit, private val unmatched: (I) -> Unit) {
    private val images = ArrayDeque<Pair<Long, I>>()
    private val results = ArrayDeque<Pair<Long, R>>()

    fun image(timestamp: Long, image: I) {
        images += timestamp to image
        if (images.size > MAX_WAITING) unmatched(images.removeFirst().second)
        match()
    }

    fun result(timestamp: Long, result: R) {
        results += timestamp to result
        if (results.size > MAX_WAITING) results.removeFirst()
        match()
    }

    /** Passes the images that wait for a result to [unmatched]. */
    fun end() {
        while (images.isNotEmpty()) unmatched(images.removeFirst().second)
    }

    private fun match() {
        while (images.isNotEmpty() && results.isNotEmpty()) {
            val order = images.first().first.compareTo(results.first().first)
            when {
                order == 0 -> pair(images.removeFirst().second, results.removeFirst().second)
                order < 0 -> unmatched(images.removeFirst().second)
                else -> results.removeFirst()
            }
        }
    }

    private companion object {
        /** More images than any camera keeps in flight. */
        const val MAX_WAITING = 16
    }
}
