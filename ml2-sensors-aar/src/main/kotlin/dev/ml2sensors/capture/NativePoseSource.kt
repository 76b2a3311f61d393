package dev.ml2sensors.capture

import dev.ml2sensors.message.toPose
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.HeadTrack
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.PosesSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.table.StreamTable

/**
 * The poses of one tracked object with one backend, 60 times a second, each stamped with the time that it is for, in
 * body axes. Samples are [PoseSample]s, or [PosesSample]s of hands.
 *
 * A pose is null while it is not tracked. A hand always has the 26 joints of OpenXR's XrHandJointEXT, in its order;
 * joints that are not tracked are NaN.
 *
 * @param suspendedNanos as [dev.ml2sensors.source.Headset.suspendedNanos].
 */
internal class NativePoseSource(
    private val sensor: PoseSensor,
    private val sensorBackend: NativeBackend,
    private val suspendedNanos: () -> Long = { 0 },
) : NativeSource(sensor.code, sensorBackend, sensor.streams, sensor.name, QUEUED_POSES) {
    /** Never conflicts: no value of a stream changes the tracker, which `tf` and `head_pose` share. */
    override fun conflict(subscription: Subscription, other: Subscription): String? = null

    override fun open(subscriptions: List<Subscription>): OpenSensor =
        OpenTracker(sensor, sensorBackend, suspendedNanos, subscriptions)

    private companion object {
        /** One quarter of a second. */
        const val QUEUED_POSES = 16
    }
}

/** The open handle of a [PoseSensor]; of the thread that makes it. */
private class OpenTracker(
    private val sensor: PoseSensor,
    private val backend: NativeBackend,
    suspendedNanos: () -> Long,
    subscriptions: List<Subscription>,
) : OpenSensor {
    private val poses = PoseBlock(MAX_POSES)
    private var settings = settings(subscriptions)
    private val handle = settings.open()
    private val schedule = PeriodicTimer(PERIOD_NANOS, Native::now, suspendedNanos)

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
        if (sensor == PoseSensor.HEAD && hasGap) LocalFrames.clearHead()
        val count = Native.pollPoses(handle, poses.memory)
        for ((number, tracked) in (0 until count).map { poses[it] }.groupBy { it.stream }) {
            val stream = StreamTable.all[number]
            val sample = if (sensor == PoseSensor.HANDS) joints(tracked) else pose(tracked.single())
            if (sensor == PoseSensor.HEAD && sample is PoseSample) LocalFrames.addHead(sample)
            for (subscription in subscriptions) {
                if (subscription.stream == stream) subscription.queue.offer(sample)
            }
        }
    }

    override fun close() {
        if (sensor == PoseSensor.HEAD) LocalFrames.clearHead()
        Native.close(handle)
    }

    private fun settings(subscriptions: List<Subscription>) =
        NativeSettings(sensor.code, backend.code, subscriptions.map { it.stream }.bits())

    private fun pose(tracked: TrackedPose): Sample =
        PoseSample(tracked.captureNanos, tracked.pose?.toBody(), tracked.isInNewWorld)

    private fun joints(tracked: List<TrackedPose>): Sample =
        PosesSample(tracked.first().captureNanos, tracked.map { it.pose?.toBody()?.toPose() ?: PosesSample.UNTRACKED })

    private companion object {
        /** 26 joints of two hands. */
        const val MAX_POSES = 52
        const val PERIOD_NANOS = 1_000_000_000L / 60
    }
}
