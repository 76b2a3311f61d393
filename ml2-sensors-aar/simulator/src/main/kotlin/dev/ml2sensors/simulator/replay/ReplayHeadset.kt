package dev.ml2sensors.simulator.replay

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.VectorSample
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withTimeoutOrNull
import kotlin.time.Duration.Companion.nanoseconds

/**
 * Plays a [recording] once, as if a headset saw it now.
 *
 * `cam0` is `world_left`, `cam1` `world_right`, `imu0` `accel_left` and `gyro_left`, the ground truth `head_pose`; all
 * values are those of the files, in the files' axes. Images have the pose that the ground truth, interpolated to their
 * time, gives their optical frame, and none outside of its span.
 *
 * The replay starts when the first flow is collected. Capture time = recorded time + one constant for all streams,
 * fixed then. The recording plays once: a stream that is collected again, after its collection ended, goes on where
 * that one was left. Flows wait for their collectors and drop nothing; they fail with [RecordingException] on an image
 * that cannot be decoded.
 *
 * @param rateFactor how many times as fast as recorded to deliver, capture times being the same; infinite: as fast as
 * the collectors take it.
 */
public class ReplayHeadset(
    private val recording: EurocRecording,
    override val clock: DeviceClock,
    rateFactor: Double,
) : Headset {
    private val closed = Job()
    private val tracks = tracks()
    private val schedule by lazy {
        Schedule(clock.nowNanos(), tracks.values.minOf { it.stamps.first() }, rateFactor)
    }

    init {
        require(rateFactor > 0) { "rate factor must be positive, not $rateFactor" }
    }

    override val identity: Headset.Identity =
        Headset.Identity("replay-${recording.name}", "Replay of ${recording.name}")

    override val timeline: Headset.Timeline get() = Headset.Timeline.RECORDED

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        if (stream !in tracks) return Answer.Refused("not in this recording")
        val camera = camera(stream) ?: return Answer.Applied(requested)
        val (width, height) = camera.intrinsics
        val own = requested.copy(width = width, height = height, rateHz = camera.rateHz, format = "Grayscale")
        return if (own == requested) Answer.Applied(own) else Answer.Adjusted(own, "the recording's own")
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        play(requireNotNull(tracks[stream]) { "${stream.id} is not in this recording" })

    /** Ends the flows, with the sample that is being delivered. */
    override fun close() {
        closed.complete()
    }

    private fun play(track: Track): Flow<Sample> = flow {
        var row = track.nextRow
        try {
            while (row < track.stamps.size) {
                val recordedNanos = track.stamps[row]
                track.sample(row, schedule.captureNanos(recordedNanos)).lend { sample ->
                    awaitDue(schedule.dueNanos(recordedNanos))
                    if (!closed.isActive) return@flow
                    row++
                    emit(sample)
                }
            }
        } finally {
            track.leave(row)
        }
    }

    private inline fun Sample.lend(use: (Sample) -> Unit) {
        try {
            use(this)
        } finally {
            if (this is ImageSample) release()
        }
    }

    private suspend fun awaitDue(dueNanos: Long) {
        withTimeoutOrNull((dueNanos - clock.nowNanos()).nanoseconds) { closed.join() }
    }

    private fun camera(stream: StreamSpec): RecordedCamera? = when (stream) {
        StreamTable.worldLeft -> recording.left
        StreamTable.worldRight -> recording.right
        else -> null
    }

    private fun tracks(): Map<StreamSpec, Track> = buildMap {
        recording.left?.let { put(StreamTable.worldLeft, CameraPlayer(it, recording.groundTruth).track()) }
        recording.right?.let { put(StreamTable.worldRight, CameraPlayer(it, recording.groundTruth).track()) }
        recording.imu?.let { imu ->
            put(StreamTable.accelLeft, Track(imu.stamps) { row, at -> imu.accel[row].sample(at) })
            put(StreamTable.gyroLeft, Track(imu.stamps) { row, at -> imu.gyro[row].sample(at) })
        }
        recording.groundTruth?.let { truth ->
            put(StreamTable.headPose, Track(truth.stamps) { row, at -> PoseSample(at, truth.poses[row]) })
        }
    }

    private fun DoubleArray.sample(captureNanos: Long) = VectorSample(captureNanos, this[0], this[1], this[2])
}
