package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.isVideo
import dev.ml2sensors.table.StreamSpec

/**
 * The streams of one camera, or of cameras that are opened together, with one backend. Samples are [ImageSample]s, and
 * [LostSamples] if a collector was too slow (`SOURCE_LATE`) or held all memory (`NO_BUFFER`). Streams that exclude each
 * other, such as depth and infra, cannot be collected at the same time.
 */
internal class NativePixelSource(private val sensor: PixelSensor, private val sensorBackend: NativeBackend) :
    NativeSource(sensor.code, sensorBackend, sensor.streams, sensor.name, QUEUED_FRAMES, isUrgent = false) {
    init {
        require(sensor != PixelSensor.COLOR || sensorBackend == NativeBackend.OPENXR) {
            "$sensor needs the backend openxr"
        }
    }

    private val depthRates =
        if (sensor == PixelSensor.DEPTH && sensorBackend == NativeBackend.SDK) DepthRates() else null

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        if (sensor == PixelSensor.COLOR && requested.isVideo) {
            return Answer.Refused("$sensorBackend has no raw images of the colour camera for video")
        }
        val answer = super.negotiate(stream, requested)
        return depthRates?.adjust(stream, requested, answer) ?: answer
    }

    override fun conflict(subscription: Subscription, other: Subscription): String? = when {
        other.stream == subscription.stream ->
            if (other.values == subscription.values) null else "it already runs with ${other.values}"

        sensor.hasOneStream -> "${other.stream} runs, and the camera delivers one of both at a time"

        else -> null
    }

    override fun open(subscriptions: List<Subscription>): OpenSensor = OpenCamera(sensor, sensorBackend, subscriptions)

    private companion object {
        const val QUEUED_FRAMES = 2
    }
}
