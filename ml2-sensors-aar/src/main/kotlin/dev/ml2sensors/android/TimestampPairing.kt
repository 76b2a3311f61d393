package dev.ml2sensors.android

/**
 * Brings images and results of the same timestamp together. Each kind comes in order, but neither before the other, and
 * some do not come at all: what is overtaken stays alone. Used by one thread.
 *
 * @param alone is told an image that stays alone; a result without an image is a frame that the device dropped.
 */
internal class TimestampPairing<I, R>(private val pair: (I, R) -> Unit, private val alone: (I) -> Unit) {
    private val images = ArrayDeque<Pair<Long, I>>()
    private val results = ArrayDeque<Pair<Long, R>>()

    fun image(timestamp: Long, image: I) {
        images += timestamp to image
        if (images.size > MOST_WAITING) alone(images.removeFirst().second)
        match()
    }

    fun result(timestamp: Long, result: R) {
        results += timestamp to result
        if (results.size > MOST_WAITING) results.removeFirst()
        match()
    }

    private fun match() {
        while (images.isNotEmpty() && results.isNotEmpty()) {
            val order = images.first().first.compareTo(results.first().first)
            when {
                order == 0 -> pair(images.removeFirst().second, results.removeFirst().second)
                order < 0 -> alone(images.removeFirst().second)
                else -> results.removeFirst()
            }
        }
    }

    private companion object {
        /** More than any camera's pipeline is deep. */
        const val MOST_WAITING = 16
    }
}
