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
 * - Down: images have waited for half a second, and some were dropped. The next level needs at most [DOWN_TARGET] of
 *   what the link delivered, but not less than a third of before. 1.5 s pass between two such steps.
 * - Up: images have not waited for 5 s, and the pacing allows what the next level needs. Where it does not, one step is
 *   tried after 30 s, since only images that wait show what a link has.
 * - A step up after which images are dropped again is taken back. The next wait is longer: 30 s, then twice as long
 *   each time, to 4 min; and then one step is taken at a time.
 *
 * Times are of one monotonic clock, in ns. Not thread-safe.
 */
internal class LinkAdaptation(private val streams: List<AdaptedStream>, order: AdaptationSpec, nowNanos: Long) {
    private val steps: List<AdaptationStep> = steps(streams, order)

    /** How many steps are in force. */
    var level: Int = (0..steps.size).first { level -> streams.all { setting(it, level).isWithin(it.present) } }
        private set

    /** A step up; a trial is one that the pacing did not allow. */
    private class Raise(val from: Int, val atNanos: Long, val isTrial: Boolean, var isTakenBack: Boolean = false)

    private val deliveries = Deliveries()
    private var steadySinceNanos = nowNanos
    private var calmSinceNanos = nowNanos
    private var raised: Raise? = null
    private var patienceNanos = PATIENCE_NANOS

    /** The pacing does not allow the next step up. */
    private var isTrial = false

    init {
        apply()
    }

    /** Follows the [link], several times a second; returns true if the level has changed. */
    fun follow(link: LinkState, nowNanos: Long): Boolean {
        deliveries.add(link.sentBytes, link.droppedImages, nowNanos)
        if (link.isUnsettled) steadySinceNanos = nowNanos
        val waitingSince = link.waitingSinceNanos?.coerceAtLeast(steadySinceNanos)
        val isPressed = waitingSince != null && nowNanos - waitingSince >= PRESSURE_NANOS
        if (isPressed || link.isUnsettled) calmSinceNanos = nowNanos
        val next = if (isPressed) lower(nowNanos) else raise(link.allowedBytesPerSecond, nowNanos)
        if (next == level) return false
        noteStep(next, nowNanos)
        level = next
        apply()
        return true
    }

    private fun lower(nowNanos: Long): Int {
        val delivered = deliveries.bytesPerSecond() ?: return level
        if (!deliveries.hasDrops) return level
        raised?.let { if (!it.isTakenBack && nowNanos - it.atNanos < RELATED_NANOS) return it.from }
        val needed = needed(level)
        val target = maxOf(DOWN_TARGET * delivered, needed / DEEPEST_STEP)
        return (level + 1..steps.size).firstOrNull { needed(it) <= target } ?: steps.size
    }

    private fun raise(allowed: Double, nowNanos: Long): Int {
        val calmNanos = nowNanos - maxOf(calmSinceNanos, steadySinceNanos)
        val isProven = raised?.let { !it.isTakenBack && nowNanos - it.atNanos > PROOF_NANOS } == true
        if (isProven) patienceNanos = PATIENCE_NANOS
        if (level == 0 || calmNanos < patienceNanos) return level
        // The pacing is not believed soon after it was found wrong
        val isBelieved = raised?.let { it.isTrial && nowNanos - it.atNanos < TRIAL_NANOS } != true
        val target = minOf(UP_TARGET * allowed, 2 * needed(level))
        val lowest = if (patienceNanos > PATIENCE_NANOS) level - 1 else 0
        val fitting = (lowest until level).firstOrNull { isBelieved && needed(it) <= target }
        isTrial = fitting == null
        return fitting ?: if (calmNanos >= maxOf(patienceNanos, TRIAL_NANOS)) level - 1 else level
    }

    private fun noteStep(next: Int, nowNanos: Long) {
        val before = raised
        if (next < level) {
            raised = Raise(level, nowNanos, isTrial)
        } else if (before == null || nowNanos - before.atNanos > RELATED_NANOS) {
            patienceNanos = maxOf(PATIENCE_NANOS, patienceNanos / 2)
            raised = null
        } else if (!before.isTakenBack) {
            patienceNanos = (2 * patienceNanos).coerceIn(TRIAL_NANOS, MOST_PATIENCE_NANOS)
            before.isTakenBack = true
        }
        // Images that waited before the step are sent first
        steadySinceNanos = nowNanos + SETTLING_NANOS
    }

    /** Returns what all images need at a level, in B/s. */
    private fun needed(level: Int) = streams.sumOf { it.bytesPerSecond(setting(it, level)) }

    private fun setting(stream: AdaptedStream, level: Int): ImageSetting =
        steps.take(level).filter { stream in it.streams }.fold(stream.configured, ImageSetting::atMost)

    private fun apply() = streams.forEach { it.present = setting(it, level) }

    private companion object {
        const val PRESSURE_NANOS = 500_000_000L
        const val SETTLING_NANOS = 1_000_000_000L
        const val PATIENCE_NANOS = 5_000_000_000L
        const val TRIAL_NANOS = 30_000_000_000L
        const val MOST_PATIENCE_NANOS = 240_000_000_000L

        /** A step down so soon after one up takes it back. */
        const val RELATED_NANOS = 60_000_000_000L

        /** A step up that lasted so long was right. */
        const val PROOF_NANOS = 15_000_000_000L

        /** The pacing goes down to this part of the link's rate: images that need more wait again. */
        const val DOWN_TARGET = 0.85
        const val UP_TARGET = 0.8
        const val DEEPEST_STEP = 3

        fun steps(streams: List<AdaptedStream>, order: AdaptationSpec): List<AdaptationStep> {
            val groups = order.streams.map { ids -> streams.filter { it.id in ids } }
            val qualities = order.qualities.flatMap { quality ->
                groups.map { group ->
                    val above = group.filter { (it.configured.quality ?: 0) > quality }
                    AdaptationStep(above.toSet(), quality, rateHz = null)
                }
            }
            val rates = groups.flatMap { group ->
                order.ratesHz.map { rateHz ->
                    val above = group.filter { it.configured.rateHz > rateHz }
                    AdaptationStep(above.toSet(), quality = null, rateHz)
                }
            }
            return (qualities + rates).filter { it.streams.isNotEmpty() }
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
