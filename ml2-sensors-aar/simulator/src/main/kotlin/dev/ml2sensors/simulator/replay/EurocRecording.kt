package dev.ml2sensors.simulator.replay

import java.io.File

/**
 * A recording in the EuRoC/ASL format. All files are checked when it is opened, except for the images, which are decoded
 * during the replay.
 *
 * It reads `cam0` (the left camera), `cam1` (the right one), `imu0` and `state_groundtruth_estimate0` in the folder
 * `mav0`. A missing folder means that the recording does not have that sensor.
 */
public class EurocRecording private constructor(
    /** The name of the folder it was read from. */
    public val name: String,
    internal val left: RecordedCamera?,
    internal val right: RecordedCamera?,
    internal val imu: RecordedImu?,
    internal val groundTruth: GroundTruth?,
) {
    public companion object {
        /**
         * @param folder the folder that holds `mav0`.
         * @throws RecordingException if there is no sensor, or a file does not follow the format.
         */
        public fun open(folder: File): EurocRecording {
            val sensors = folder.resolve("mav0")

            fun <T> sensor(name: String, open: (File) -> T): T? =
                sensors.resolve(name).takeIf(File::isDirectory)?.let(open)

            val recording = EurocRecording(
                folder.canonicalFile.name,
                sensor("cam0", RecordedCamera::open),
                sensor("cam1", RecordedCamera::open),
                sensor("imu0", RecordedImu::open),
                sensor("state_groundtruth_estimate0", GroundTruth::open),
            )
            val found = listOf(recording.left, recording.right, recording.imu, recording.groundTruth)
            if (found.all { it == null }) {
                val expected = "cam0, cam1, imu0 or state_groundtruth_estimate0"
                throw RecordingException(sensors, null, expected, "none of them")
            }
            return recording
        }
    }
}
