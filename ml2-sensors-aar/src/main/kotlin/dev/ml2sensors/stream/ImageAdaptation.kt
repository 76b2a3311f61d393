package dev.ml2sensors.stream

import dev.ml2sensors.pacing.AdaptedStream
import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.pacing.ImageSetting
import dev.ml2sensors.pacing.LinkAdaptation
import dev.ml2sensors.session.Lane
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.delay
import kotlin.time.Duration.Companion.milliseconds

/**
 * Has the images of all streams give way to the link. Thread-safe.
 *
 * @param lane returns the lane of a stream.
 * @param report receives an event for each change.
 */
internal class ImageAdaptation(private val lane: (String) -> Lane, private val report: (Event) -> Unit) {
    private val streams = LinkedHashMap<String, AdaptedStream>()

    /** Null while nothing adapts. */
    private var adaptation: LinkAdaptation? = null

    /** Returns [state] of the stream [id] with what is lowered of its images. */
    fun lowered(id: String, state: Status.Stream): Status.Stream {
        val (configured, present) = synchronized(streams) { streams[id]?.let { it.configured to it.present } }
            ?: return state
        return state.lowered(
            quality = present.quality.takeIf { it != configured.quality },
            rateHz = present.rateHz.takeIf { it != configured.rateHz },
        )
    }

    /** Configures all streams; those with the same setting go on as they are. */
    fun configure(configured: Map<String, ImageSetting>, adapts: Boolean): Unit = synchronized(streams) {
        val isSame = configured == streams.mapValues { it.value.configured }
        if (isSame && adapts == (adaptation != null)) return
        streams.entries.removeIf { (id, it) -> configured[id] != it.configured }
        configured.forEach { (id, setting) -> streams.getOrPut(id) { AdaptedStream(id, setting) } }
        adaptation = if (adapts) adaptationOf(streams.values.toList()) else null
        if (adapts || streams.values.all { it.present == it.configured }) return
        streams.values.forEach { it.present = it.configured }
        reportLowered()
    }

    private fun adaptationOf(streams: List<AdaptedStream>) =
        LinkAdaptation(streams, StreamTable.adaptation, System.nanoTime())

    /** Returns the configured stream [id]. */
    fun stream(id: String): AdaptedStream = synchronized(streams) { streams.getValue(id) }

    /** Adapts images to what [pacing] knows of its link, until it is cancelled. */
    suspend fun adaptTo(pacing: ImagePacing): Nothing {
        while (true) {
            delay(INTERVAL)
            synchronized(streams) {
                val lanes = streams.keys.map(lane)
                val waitingSince = lanes.mapNotNull { it.waitingSinceNanos }.minOrNull()
                val link = pacing.linkState(waitingSince, lanes.sumOf { it.overflows })
                if (adaptation?.adaptTo(link, System.nanoTime()) == true) reportLowered()
                pacing.wantMore(streams.values.any { it.present != it.configured })
            }
        }
    }

    private fun reportLowered() {
        val alike = streams.values.groupBy(::words) { it.id }.filterKeys(String::isNotEmpty)
        val text = if (alike.isEmpty()) {
            "all images are as configured"
        } else {
            "images give way to the link: " +
                alike.entries.joinToString("; ") { (words, ids) -> "${ids.joinToString()}: $words" }
        }
        report(Event(Event.ADAPTED, text))
    }

    /** Returns what is lowered of a stream; empty if nothing is. */
    private fun words(stream: AdaptedStream): String = listOfNotNull(
        stream.present.quality?.takeIf { it != stream.configured.quality }?.let { "quality $it" },
        stream.present.rateHz.takeIf { it != stream.configured.rateHz }?.let { "$it Hz" },
    ).joinToString()

    private companion object {
        val INTERVAL = 100.milliseconds
    }
}
