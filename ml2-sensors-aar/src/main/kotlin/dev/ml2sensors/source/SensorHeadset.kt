package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.flow.Flow

/**
 * A live headset made of [sources], which it owns. The backend of a stream is the one that its values name, else the
 * first one in the stream table that some source offers.
 */
internal class SensorHeadset(
    override val identity: Headset.Identity,
    override val clock: DeviceClock,
    private val sources: List<SensorSource>,
    override val videoEncoders: VideoEncoders? = null,
    private val readPermissions: () -> Map<String, Boolean> = ::emptyMap,
) : Headset {
    @Volatile
    private var isPaused = false

    override val timeline: Headset.Timeline get() = Headset.Timeline.LIVE
    override val permissions: Map<String, Boolean> get() = readPermissions()

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        val source = source(stream, requested)
        if (source != null) return source.negotiate(stream, requested)
        val offered = sources.filter { stream in it.streams }.map { it.backend }
        return when {
            offered.isEmpty() -> Answer.Refused("this headset has no $stream")

            else -> Answer.Refused(
                "this headset has no backend ${requested.backend} for $stream, only ${offered.joinToString()}",
            )
        }
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        requireNotNull(source(stream, values)) { "$stream was not accepted with $values" }.samples(stream, values)

    override val holds: Map<String, String>
        get() = if (isPaused) sources.flatMap { it.streams }.associate { it.id to PAUSED } else emptyMap()

    /** Releases all sensors at once, while the app is in the background. Flows continue and deliver nothing. */
    fun pause() {
        isPaused = true
        sources.forEach(SensorSource::pause)
    }

    /** Opens the sensors again; a flow whose sensor cannot be opened fails. */
    fun resume() {
        sources.forEach(SensorSource::resume)
        isPaused = false
    }

    override fun close(): Unit = sources.forEach(SensorSource::close)

    private fun source(stream: StreamSpec, values: StreamValues): SensorSource? {
        val wanted = values.backend?.let(::listOf) ?: stream.backends
        return wanted.firstNotNullOfOrNull { name ->
            sources.firstOrNull { it.backend == name && stream in it.streams }
        }
    }

    private companion object {
        const val PAUSED = "paused while the app is in the background"
    }
}
