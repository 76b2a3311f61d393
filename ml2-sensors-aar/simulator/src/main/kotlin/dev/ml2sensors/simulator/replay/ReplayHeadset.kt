package dev.ml2sensors.simulator.replay

import dev.ml2sensors.simulator.signal.waitUntil
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

/**
 * Replays a [recording] once, as if a headset captured it now.
 *
 * `cam0` is `world_left`, `cam1` is `world_right`, `imu0` is `accel_left` and `gyro_left`, and the ground truth is
 * `head_pose`. All values are those of the files, in the axes of the files. The pose of an image is that of its optical
 * frame, from the ground truth interpolated to the image's time. It is null outside the time of the ground truth.
 *
 * The replay starts when the first flow is collected. Then the capture time of a sample is its recorded time plus one
 * constant for all streams. A stream that is collected a second time resumes where the first collection ended. Flows
 * wait for their collectors and drop nothing. They fail with [RecordingException] on an image that cannot be decoded.
 *
 * @param rateFactor how many times as fast as recorded samples are delivered; infinite for as fast as collectors take
 * them. Capture times are the same for all factors.
 */
public class ReplayHeadset(
    private val recording: EurocRecording,
    override val clock: DeviceClock,
    rateFactor: Double,
) : Headset {
    private val closed = Job()
    private val tracks = tracks()
    private val schedule by lazy {
        ReplaySchedule(clock.nowNanos(), tracks.values.minOf { it.stamps.first() }, rateFactor)
    }

    init {
        require(rateFactor > 0) { "expected a positive rate factor, found $rateFactor" }
    }

    override val identity: Headset.Identity =
        Headset.Identity("replay-${recording.name}", "Replay of ${recording.name}")

    override val timeline: Headset.Timeline get() = Headset.Timeline.RECORDED

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer {
        if (stream !in tracks) return Answer.Refused("not in this recording")
        val camera = camera(stream) ?: return Answer.Applied(requested)
        val (width, height) = camera.intrinsics
        val own = requested.copy(width = width, height = height, rateHz = camera.rateHz)
        return if (own == requested) Answer.Applied(own) else Answer.Adjusted(own, "the recording's own")
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        play(requireNotNull(tracks[stream]) { "${stream.id} is not in this recording" })

    /** Ends the flows after the sample that is being delivered. */
    override fun close() {
        closed.complete()
    }

    private fun play(track: ReplayTrack): Flow<Sample> = flow {
        var row = track.nextRow
        try {
            while (row < track.stamps.size) {
                val recordedNanos = track.stamps[row]
                track.sample(row, schedule.captureNanos(recordedNanos)).useThenRelease { sample ->
                    if (!clock.waitUntil(schedule.dueNanos(recordedNanos), closed)) return@flow
                    row++
                    emit(sample)
                }
            }
        } finally {
            track.resumeAt(row)
        }
    }

    private inline fun Sample.useThenRelease(use: (Sample) -> Unit) {
        try {
            use(this)
        } finally {
            if (this is ImageSample) release()
        }
    }

    private fun camera(stream: StreamSpec): RecordedCamera? = when (stream) {
        StreamTable.worldLeft -> recording.left
        StreamTable.worldRight -> recording.right
        else -> null
    }

    private fun tracks(): Map<StreamSpec, ReplayTrack> = buildMap {
        recording.left?.let { put(StreamTable.worldLeft, CameraPlayer(it, recording.groundTruth).track()) }
        recording.right?.let { put(StreamTable.worldRight, CameraPlayer(it, recording.groundTruth).track()) }
        recording.imu?.let { imu ->
            put(StreamTable.accelLeft, ReplayTrack(imu.stamps) { row, at -> imu.accel[row].sample(at) })
            put(StreamTable.gyroLeft, ReplayTrack(imu.stamps) { row, at -> imu.gyro[row].sample(at) })
        }
        recording.groundTruth?.let { truth ->
            put(StreamTable.headPose, ReplayTrack(truth.stamps) { row, at -> PoseSample(at, truth.poses[row]) })
        }
    }

    private fun DoubleArray.sample(captureNanos: Long) = VectorSample(captureNanos, this[0], this[1], this[2])
}
