package dev.ml2sensors.source

import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow

/**
 * Adds derived streams to [headset]: `imu_*` of both sensors of a unit, `tf` of the head's poses, and `custom`, whose
 * messages the app makes. Refuses video that the headset's platform does not encode.
 */
internal class DerivedStreamsHeadset(
    private val headset: Headset,
    private val calls: PlatformCalls = PlatformCalls(),
) : Headset by headset {
    /** Negotiates with the headset; a source that throws or does not answer refuses only its own stream. */
    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = try {
        calls.call("the sensor of $stream is asked what it can do") { answer(stream, requested) }
    } catch (e: NoAnswerException) {
        Answer.Refused(e.message.orEmpty())
    } catch (e: Exception) {
        Answer.Refused("${e.javaClass.simpleName}: ${e.message}")
    }

    private fun answer(stream: StreamSpec, requested: StreamValues): Answer {
        if (stream == StreamTable.custom) return custom(requested)
        val parts = partsOf(stream) ?: return sensor(stream, requested)
        val refusal = parts.map { headset.negotiate(it, requested) }.firstOrNull { it is Answer.Refused }
        return when {
            refusal != null -> refusal

            requested.layout == "rig" && timeline == Headset.Timeline.RECORDED ->
                Answer.Adjusted(requested.copy(layout = "flat"), "the poses of a recording are sent as they are")

            else -> Answer.Applied(requested)
        }
    }

    private fun sensor(stream: StreamSpec, requested: StreamValues): Answer {
        val answer = headset.negotiate(stream, requested)
        val video = answer.acceptedValues?.video() ?: return answer
        val encoders = videoEncoders ?: return Answer.Refused("this headset encodes no video")
        return encoders.refusal(video)?.let { Answer.Refused(it) } ?: answer
    }

    private fun custom(requested: StreamValues): Answer = when (timeline) {
        Headset.Timeline.LIVE -> Answer.Applied(requested)
        Headset.Timeline.RECORDED -> Answer.Refused("a recording takes no topics from apps")
    }

    override val holds: Map<String, String>
        get() {
            val held = headset.holds
            if (held.isEmpty()) return held
            fun why(stream: StreamSpec) = (partsOf(stream) ?: listOf(stream)).firstNotNullOfOrNull { held[it.id] }
            return StreamTable.all.mapNotNull { stream -> why(stream)?.let { stream.id to it } }.toMap()
        }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> {
        val parts = partsOf(stream)?.map { headset.samples(it, values) } ?: return headset.samples(stream, values)
        return if (parts.size == 2) joinInertial(parts[0], parts[1]) else parts.single()
    }

    /** Returns the streams that [stream] is derived from, or null for a sensor's own stream. */
    private fun partsOf(stream: StreamSpec): List<StreamSpec>? =
        if (stream == StreamTable.tf) {
            listOf(StreamTable.headPose)
        } else {
            ImuUnit.entries.firstOrNull { it.combined == stream }?.let { listOf(it.gyroscope, it.accelerometer) }
        }
}
