package dev.ml2sensors.pacing

import dev.ml2sensors.table.AdaptationSpec

/** One step by which streams give way: to a [quality] of JPEG or to a rate. */
internal class AdaptationStep(val streams: Set<AdaptedStream>, val quality: Int?, val rateHz: Int?)

/**
 * The state of a link at one time.
 *
 * @property waitingSinceNanos since when an image lane has always had something to send; null if all have pauses.
 * @property isUnsettled true while the link stands still, or while the pacing does not know its rate yet.
 * @property droppedImages how many images were dropped so far because newer ones came before the link took them.
 * @property sentBytes what all image lanes of the present session have sent so far.
 * @property allowedBytesPerSecond the rate of the pacing.
 */
internal class LinkState(
    val waitingSinceNanos: Long?,
    val isUnsettled: Boolean,
    val droppedImages: Long,
    val sentBytes: Long,
    val allowedBytesPerSecond: Double,
)

/**
 * Lowers what images need when the link carries less, and raises it again: a state machine over [steps], of which the
 * first [level] are in force.
 *
 * - Down: images have waited for half a second, or for 2 s if the pacing allows what they need, and some were dropped.
 *   The next level needs at most [DOWN_TARGET] of what the link delivered, but not less than a third of before.
 * - Up: images have not waited for 5 s. The next level needs at most what the pacing allows, and at most three times as
 *   much as the present one. Where the pacing allows none, a little more is tried: only images that wait show what a link
 *   carries.
 * - A step up after which images are dropped again, though the link carries what it did before, is taken back, as far as
 *   [MISTAKE_TARGET] of what the link delivered needs. For a minute, then for twice as long each time, to 4 min, no more
 *   than that is tried, unless the pacing allows much more than it did.
 *
 * Times are of one monotonic clock, in ns. Not thread-safe.
 */
internal class LinkAdaptation(private val streams: List<AdaptedStream>, order: AdaptationSpec, nowNanos: Long) {
    private val steps: List<AdaptationStep> = steps(streams, order)

    /** The number of steps in force. */
    var level: Int = (0..steps.size).first { level -> streams.all { setting(it, level).isWithin(it.present) } }
        private set

    /** A step up when the pacing allowed [allowed] B/s. */
    private class Raise(val from: Int, val atNanos: Long, val allowed: Double)

    /** A step up to [to] that was taken back: the link delivered [carried], the pacing had allowed [allowed] B/s. */
    private class Mistake(val from: Int, val to: Int, val atNanos: Long, val carried: Double, val allowed: Double)

    private val deliveries = Deliveries()
    private var steadySinceNanos = nowNanos
    private var calmSinceNanos = nowNanos

    /** The last step up; null if it was taken back. */
    private var raised: Raise? = null
    private var mistake: Mistake? = null

    /** The number of steps up that were taken back since the last right one, or since the link became worse. */
    private var mistakes = 0

    init {
        apply()
    }

    /** Adapts to the [link], several times a second; returns true if the level has changed. */
    fun adaptTo(link: LinkState, nowNanos: Long): Boolean {
        deliveries.add(link.sentBytes, link.droppedImages, nowNanos)
        if (link.isUnsettled) steadySinceNanos = nowNanos
        val waitedNanos = link.waitingSinceNanos?.let { nowNanos - maxOf(it, steadySinceNanos) } ?: 0
        val isPressed = waitedNanos >= PRESSURE_NANOS
        if (isPressed || link.isUnsettled) calmSinceNanos = nowNanos
        val isBacklog = waitedNanos < backlogNanos(link.allowedBytesPerSecond, nowNanos)
        val next = when {
            !isPressed -> raise(link.allowedBytesPerSecond, nowNanos)
            isBacklog -> level
            else -> lower(nowNanos)
        }
        if (next == level) return false
        level = next
        // Images that waited before the step are sent first
        steadySinceNanos = nowNanos + SETTLING_NANOS
        apply()
        return true
    }

    /** Returns for how long images may wait, if the link carries the present level and they only send a backlog. */
    private fun backlogNanos(allowed: Double, nowNanos: Long): Long {
        val mistake = mistake
        val isTakenBack = mistake != null && mistake.from == level && nowNanos - mistake.atNanos < RELATED_NANOS
        return when {
            isTakenBack -> PATIENCE_NANOS
            needed(level) < allowed -> BACKLOG_NANOS
            else -> 0
        }
    }

    private fun lower(nowNanos: Long): Int {
        val delivered = deliveries.bytesPerSecond() ?: return level
        if (!deliveries.hasDrops) return level
        val before = takenBack(delivered, nowNanos)
        val part = if (before == null) DOWN_TARGET else MISTAKE_TARGET
        val target = maxOf(part * delivered, needed(level) / DEEPEST_STEP)
        val fitting = (level + 1..steps.size).firstOrNull { needed(it) <= target } ?: steps.size
        return minOf(before ?: fitting, fitting)
    }

    /** Returns the level before a recent step up that was a mistake; null if there was none. */
    private fun takenBack(delivered: Double, nowNanos: Long): Int? {
        val last = raised?.takeIf { nowNanos - it.atNanos < RELATED_NANOS } ?: return null
        raised = null
        if (delivered < WORSE_LINK * needed(last.from)) {
            mistake = null
            mistakes = 0
            return null
        }
        mistake = Mistake(last.from, level, nowNanos, delivered, last.allowed)
        mistakes = minOf(mistakes + 1, MOST_MISTAKES)
        return last.from
    }

    private fun raise(allowed: Double, nowNanos: Long): Int {
        val calmNanos = nowNanos - maxOf(calmSinceNanos, steadySinceNanos)
        if (level == 0 || calmNanos < PATIENCE_NANOS) return level
        val last = raised
        if (last != null && nowNanos - last.atNanos > RELATED_NANOS) mistakes = 0
        val most = mostCarried(allowed, nowNanos)
        val fitting = minOf(UP_TARGET * allowed, HIGHEST_STEP * needed(level))
        val target = minOf(most, maxOf(fitting, TRIED_STEP * needed(level)))
        val first = if (most.isInfinite()) 0 else checkNotNull(mistake).to + 1
        val fitsAt = (first until level).firstOrNull { needed(it) <= target }
        val next = when {
            most.isInfinite() -> fitsAt ?: (level - 1)
            fitsAt != null && needed(fitsAt) > LEAST_STEP * needed(level) -> fitsAt
            else -> level
        }
        if (next < level) raised = Raise(level, nowNanos, allowed)
        return next
    }

    /** Returns what the link is known to carry at most, in B/s, by a mistake that still counts. */
    private fun mostCarried(allowed: Double, nowNanos: Long): Double {
        val mistake = mistake ?: return Double.POSITIVE_INFINITY
        // The more often that was wrong, the more the pacing must allow until it is believed
        val doublings = maxOf(0, mistakes - 1)
        val isBetter = allowed > BETTER_LINK * (1 shl doublings) * maxOf(mistake.carried, mistake.allowed)
        val isOver = nowNanos - mistake.atNanos > LONG_PATIENCE_NANOS shl doublings
        return if (isBetter || isOver) Double.POSITIVE_INFINITY else MISTAKE_TARGET * mistake.carried
    }

    /** Returns what all images need at a level, in B/s. */
    private fun needed(level: Int) = streams.sumOf { it.bytesPerSecond(setting(it, level)) }

    private fun setting(stream: AdaptedStream, level: Int): ImageSetting =
        steps.take(level).filter { stream in it.streams }.fold(stream.configured, ImageSetting::atMost)

    private fun apply() = streams.forEach { it.present = setting(it, level) }

    private companion object {
        const val PRESSURE_NANOS = 500_000_000L
        const val BACKLOG_NANOS = 2_000_000_000L
        const val SETTLING_NANOS = 1_000_000_000L
        const val PATIENCE_NANOS = 5_000_000_000L
        const val LONG_PATIENCE_NANOS = 60_000_000_000L

        /** After so many, the wait is four minutes. */
        const val MOST_MISTAKES = 3

        /** A step down so soon after one up takes it back; one up that lasted longer was right. */
        const val RELATED_NANOS = 60_000_000_000L

        /** A link that carries less than this part of what it did before a step up has become worse. */
        const val WORSE_LINK = 0.7

        /** A link has become better if the pacing allows so many times what it carried, and allowed, at a mistake. */
        const val BETTER_LINK = 2.0

        /** The pacing goes down to 0.85 of the link's rate for moments, which the queues of images bridge. */
        const val DOWN_TARGET = 0.95

        /** After a mistake: the size of the images varies, and a level that just fits would be a mistake again. */
        const val MISTAKE_TARGET = 0.9
        const val UP_TARGET = 0.8
        const val DEEPEST_STEP = 3
        const val HIGHEST_STEP = 3

        /** Less more is not worth a step while a mistake counts. */
        const val LEAST_STEP = 1.05

        /** So much more than before is tried where the pacing does not allow a step. */
        const val TRIED_STEP = 1.15

        fun steps(streams: List<AdaptedStream>, order: AdaptationSpec): List<AdaptationStep> {
            val groups = order.streams.map { ids -> streams.filter { it.id in ids } }
            val qualities = order.qualities.flatMap { quality ->
                groups.map { group ->
                    val above = group.filter { (it.configured.quality ?: 0) > quality }
                    AdaptationStep(above.toSet(), quality, rateHz = null)
                }
            }
            val rounds = groups.zip(order.firstRoundHz) { group, leastHz ->
                rateSteps(group, order.ratesHz).partition { checkNotNull(it.rateHz) >= leastHz }
            }
            val rates = rounds.flatMap { it.first } + rounds.flatMap { it.second }
            return (qualities + rates).filter { it.streams.isNotEmpty() }
        }

        fun rateSteps(group: List<AdaptedStream>, ratesHz: List<Int>) = ratesHz.map { rateHz ->
            val above = group.filter { it.configured.rateHz > rateHz }
            AdaptationStep(above.toSet(), quality = null, rateHz)
        }
    }
}

/** Counts the bytes sent and the images dropped in the last half second. */
private class Deliveries {
    private class Total(val bytes: Long, val drops: Long, val atNanos: Long)

    private val totals = ArrayDeque<Total>()

    val hasDrops: Boolean get() = totals.last().drops > totals.first().drops

    fun add(bytes: Long, drops: Long, nowNanos: Long) {
        val isNewSession = totals.isNotEmpty() && bytes < totals.last().bytes
        if (isNewSession) totals.clear()
        totals.addLast(Total(bytes, drops, nowNanos))
        while (totals.size > 2 && nowNanos - totals[1].atNanos >= WINDOW_NANOS) totals.removeFirst()
    }

    /** Returns the rate in B/s; null if the time is too short. */
    fun bytesPerSecond(): Double? {
        val (first, last) = totals.first() to totals.last()
        val nanos = last.atNanos - first.atNanos
        return if (nanos < WINDOW_NANOS / 2) null else (last.bytes - first.bytes) * 1e9 / nanos
    }

    private companion object {
        const val WINDOW_NANOS = 500_000_000L
    }
}
