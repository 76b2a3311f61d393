package dev.ml2sensors.stream

import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.TransformStamped
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.times
import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock

/**
 * What goes out on `/tf`, flat: every frame is a child of the world. A transform stamped exactly like each image, and
 * beside it, when [composes], the poses of all sensors at each head pose: the head's composed with the latest
 * head-to-sensor transform. At most one transform per child and stamp. Called by any stream.
 */
internal class TransformTree(
    private val channel: () -> OutgoingChannel,
    private val stamps: StampMap,
    private val composes: Boolean,
) {
    private val mutex = Mutex()
    private val mountings = SensorMountings()
    private val lastStamps = HashMap<String, RecentStamps>()

    /** A pose of the head; nothing is sent while it is not tracked. */
    suspend fun head(sample: PoseSample): Unit =
        mutex.withLock {
            val pose = sample.pose ?: return mountings.headLost()
            val frames = mutableListOf(StreamTable.HEAD_FRAME to pose)
            if (composes) {
                mountings.head(sample.captureNanos, pose)
                mountings.forEach { spec, mounting -> frames += spec.frames(pose * mounting) }
            }
            publish(sample.captureNanos, frames)
        }

    /** The pose of a camera at one of its captures. */
    suspend fun camera(
        spec: StreamSpec,
        sample: ImageSample,
    ): Unit =
        mutex.withLock {
            val pose = sample.pose ?: return
            if (composes) mountings.camera(spec, sample.captureNanos, pose)
            publish(sample.captureNanos, spec.frames(pose))
        }

    /** A stream stopped: its pose is no longer composed, or none is when it was the head's. */
    suspend fun forget(spec: StreamSpec): Unit =
        mutex.withLock { if (spec == StreamTable.tf) mountings.headLost() else mountings.forget(spec) }

    private fun StreamSpec.frames(optical: Transform): List<Pair<String, Transform>> =
        listOf(frameId to optical, checkNotNull(bodyFrameId) to optical * BODY_IN_OPTICAL)

    private suspend fun publish(
        captureNanos: Long,
        frames: List<Pair<String, Transform>>,
    ) {
        val stampNanos = stamps.stampNanos(captureNanos) ?: return channel().account.lose(1, DropReason.CLOCK_STEP)
        val header = Header(Time.ofNanos(stampNanos), StreamTable.WORLD_FRAME)
        val fresh = frames.filter { (child, _) -> lastStamps.getOrPut(child, ::RecentStamps).add(stampNanos) }
        if (fresh.isEmpty()) return
        val message = TFMessage(fresh.map { (child, transform) -> TransformStamped(header, child, transform) })
        channel().publish(TFMessage.serializer(), message, stampNanos)
    }

    private companion object {
        val BODY_IN_OPTICAL = OPTICAL_IN_BODY.inverse()
    }
}

/** The latest stamps of one child: enough to see a repetition, since streams deliver in order. */
private class RecentStamps {
    private val stamps = LongArray(64) { Long.MIN_VALUE }
    private var next = 0

    /** False when [stampNanos] is among them. */
    fun add(stampNanos: Long): Boolean {
        if (stampNanos in stamps) return false
        stamps[next] = stampNanos
        next = (next + 1) % stamps.size
        return true
    }
}
