package dev.ml2sensors.capture

import dev.ml2sensors.message.toPose
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Condition
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.HeadTrack
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.source.MarkersSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable

/**
 * The readings of one tracked object with one backend, 60 times a second, markers and maps 30 times, each stamped with
 * the time that it is for. Samples are [PoseSample]s in body axes, [PosesSample]s of hands, [InputSample]s, [MarkersSample]s
 * or [MapSample]s.
 *
 * A pose is null while it is not tracked. A hand always has the 26 joints of OpenXR's XrHandJointEXT, in its order;
 * joints that are not tracked are NaN. Flows of input fail after a second in which no controller is connected.
 *
 * @param suspendedNanos as [dev.ml2sensors.source.Headset.suspendedNanos].
 */
internal class NativeReadingSource(
    private val sensor: ReadingSensor,
    private val sensorBackend: NativeBackend,
    private val suspendedNanos: () -> Long = { 0 },
) : NativeSource(sensor.code, sensorBackend, sensor.streams, sensor.name, QUEUED_READINGS, isUrgent = true) {
    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = try {
        if (sensor == ReadingSensor.MARKERS) MarkerSettings.of(requested)
        if (sensor == ReadingSensor.MAP) MapSettings.of(requested)
        super.negotiate(stream, requested)
    } catch (e: IllegalArgumentException) {
        Answer.Refused(checkNotNull(e.message))
    }

    /** Only markers and maps conflict: no value changes another tracker; `tf` and `head_pose` share that of the head. */
    override fun conflict(subscription: Subscription, other: Subscription): String? = when {
        subscription.values == other.values -> null
        sensor == ReadingSensor.MARKERS -> "the detector looks for markers with ${other.values}"
        sensor == ReadingSensor.MAP -> "the map is followed with ${other.values}"
        else -> null
    }

    override fun open(subscriptions: List<Subscription>): OpenSensor =
        OpenTracker(sensor, sensorBackend, suspendedNanos, subscriptions)

    companion object {
        /** One quarter of a second. */
        private const val QUEUED_READINGS = 16

        /** Returns a source of each sensor that [backend] can read. */
        fun all(backend: NativeBackend, suspendedNanos: () -> Long = { 0 }): List<NativeReadingSource> =
            ReadingSensor.entries.filter { backend in it.backends }
                .map { NativeReadingSource(it, backend, suspendedNanos) }
    }
}

/** The open handle of a [ReadingSensor]; of the thread that makes it. */
private class OpenTracker(
    private val sensor: ReadingSensor,
    private val backend: NativeBackend,
    suspendedNanos: () -> Long,
    subscriptions: List<Subscription>,
) : OpenSensor {
    private val readings = ReadingBlock(sensor.mostReadings)
    private var settings = settings(subscriptions)
    private val handle = settings.open()
    private val schedule = PeriodicTimer(1_000_000_000L / sensor.rateHz, Native::now, suspendedNanos)
    private var pollsWithoutInput = 0

    override fun configure(subscriptions: List<Subscription>) {
        val next = settings(subscriptions)
        if (next == settings) return
        next.configure(handle)
        settings = next
    }

    override fun deliver(subscriptions: List<Subscription>) {
        val missed = schedule.awaitNext()
        if (missed > 0) subscriptions.forEach { it.queue.countLost(missed, DropReason.SOURCE_LATE) }
        val hasGap = missed > HeadTrack.MAX_BRIDGED || schedule.wasSuspended
        if (sensor == ReadingSensor.HEAD && hasGap) LocalFrames.clearHead()
        val count = Native.pollReadings(handle, readings.memory)
        val all = (0 until count).map { readings[it] }
        if (sensor == ReadingSensor.MARKERS) return subscriptions.offer(StreamTable.markers, markers(all))
        for ((number, found) in all.groupBy { it.stream }) {
            val sample = sample(found) ?: continue
            if (sensor == ReadingSensor.HEAD && sample is PoseSample) LocalFrames.addHead(sample)
            subscriptions.offer(StreamTable.all[number], sample)
        }
    }

    private fun List<Subscription>.offer(stream: StreamSpec, sample: Sample) {
        for (subscription in this) if (subscription.stream == stream) subscription.queue.offer(sample)
    }

    override fun close() {
        if (sensor == ReadingSensor.HEAD) LocalFrames.clearHead()
        Native.close(handle)
    }

    private fun settings(subscriptions: List<Subscription>) =
        NativeSettings(
            sensor.code,
            backend.code,
            subscriptions.map { it.stream }.bits(),
            markers = if (sensor == ReadingSensor.MARKERS) {
                MarkerSettings.of(subscriptions.first().values)
            } else {
                MarkerSettings()
            },
            map = if (sensor == ReadingSensor.MAP) MapSettings.of(subscriptions.first().values) else MapSettings(),
        )

    /** Returns what is seen, which may be nothing, so that readers know that the detector runs. */
    private fun markers(found: List<Reading>) = MarkersSample(
        found.firstOrNull()?.captureNanos ?: Native.now(),
        found.mapNotNull(settings.markers::marker),
    )

    private fun sample(found: List<Reading>): Sample? =
        when (sensor) {
            ReadingSensor.HANDS -> joints(found)
            ReadingSensor.CONTROLLER_INPUT -> input(found.single())
            ReadingSensor.MAP -> MapSettings.sample(found.single())
            else -> pose(found.single())
        }

    private fun pose(found: Reading) =
        PoseSample(found.captureNanos, found.pose?.toBody(), found.isInNewWorld, condition(found))

    private fun condition(found: Reading): Condition? = when {
        sensor == ReadingSensor.HEAD -> headCondition(found)
        sensor == ReadingSensor.GAZE && backend == NativeBackend.OPENXR -> gazeCondition(found)
        else -> null
    }

    private fun joints(found: List<Reading>) =
        PosesSample(found.first().captureNanos, found.map { it.pose?.toBody()?.toPose() ?: PosesSample.UNTRACKED })

    private fun input(found: Reading): InputSample? {
        pollsWithoutInput = if (found.isTracked) 0 else pollsWithoutInput + 1
        if (pollsWithoutInput > sensor.rateHz) throw CaptureException.NotAvailable("no controller is connected")
        if (!found.isTracked) return null
        return InputSample(
            found.captureNanos,
            trigger = found.value(Reading.INPUT_TRIGGER),
            bumper = found.value(Reading.INPUT_BUMPER) != 0f,
            menu = found.value(Reading.INPUT_MENU) != 0f,
            isTouched = found.value(Reading.INPUT_TOUCHED) != 0f,
            touchX = found.value(Reading.INPUT_TOUCH_X),
            touchY = found.value(Reading.INPUT_TOUCH_Y),
            force = found.value(Reading.INPUT_FORCE),
        )
    }
}
