package dev.ml2sensors.capture

import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.LostSamples

/**
 * The streams of one camera, or of cameras that are opened together, by one way to them. Samples are
 * [ImageSample]s, and [LostSamples] where a collector was too slow (`SOURCE_LATE`) or kept all memory (`NO_BUFFER`).
 * Streams that exclude each other, such as depth and infra, cannot be collected at a time.
 */
public class NativePixelSource(private val sensor: PixelSensor, private val sensorBackend: NativeBackend) :
    NativeSource(sensor.code, sensorBackend, sensor.streams, sensor.name, QUEUED_FRAMES) {
    init {
        require(sensor != PixelSensor.COLOR || sensorBackend == NativeBackend.OPENXR) { "$sensor is for OpenXR only" }
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
