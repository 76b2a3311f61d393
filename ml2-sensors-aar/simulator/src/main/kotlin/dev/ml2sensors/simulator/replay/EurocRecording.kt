package dev.ml2sensors.simulator.replay

import java.io.File

/** The folder of the poses of the body, as EuRoC, Monado and TUM-VI name it. */
private val GROUND_TRUTHS = listOf("state_groundtruth_estimate0", "gt", "mocap0")

/**
 * A recording in the EuRoC/ASL format, as EuRoC, TUM-VI, Monado and others write it. Opening it checks all files but the
 * pixels of the images, which are decoded during the replay.
 *
 * It reads `cam0` (the left camera), `cam1` (the right one), `imu0`, and `state_groundtruth_estimate0`, `gt` or `mocap0`
 * in the folder `mav0`. A missing folder means that the recording does not have that sensor.
 */
public class EurocRecording private constructor(
    /** The name of the folder it was read from. */
    public val name: String,
    internal val left: RecordedCamera?,
    internal val right: RecordedCamera?,
    internal val imu: RecordedImu?,
    internal val groundTruth: GroundTruth?,
    /** A sentence for each thing that is left out or converted. */
    public val notes: List<String>,
) {
    public companion object {
        /**
         * @param folder the folder that holds `mav0`, or `mav0` itself.
         * @throws RecordingException if there is no sensor, or a file does not follow the format.
         */
        public fun open(folder: File): EurocRecording {
            val sensors = folder.resolve("mav0").takeIf(File::isDirectory) ?: folder
            val notes = mutableListOf<String>()
            val groundTruth = GROUND_TRUTHS.firstOrNull { sensors.resolve(it).isDirectory }

            fun <T> sensor(name: String, open: (File, MutableList<String>) -> T): T? =
                sensors.resolve(name).takeIf(File::isDirectory)?.let { open(it, notes) }

            val recording = EurocRecording(
                name(folder.canonicalFile),
                sensor("cam0", RecordedCamera::open),
                sensor("cam1", RecordedCamera::open),
                sensor("imu0", RecordedImu::open),
                groundTruth?.let { sensor(it, GroundTruth::open) },
                notes,
            )
            val found = listOf(recording.left, recording.right, recording.imu, recording.groundTruth)
            if (found.all { it == null }) throw nothingIn(folder)
            val others = sensors.list { file, name -> file.resolve(name).resolve("data.csv").isFile }.orEmpty()
                .filterNot { it in setOf("cam0", "cam1", "imu0", groundTruth) }
            if (others.isNotEmpty()) notes += "$sensors: not replayed: ${others.sorted().joinToString()}"
            return recording
        }

        private fun name(folder: File): String =
            if (folder.name == "mav0") folder.parentFile?.name ?: folder.name else folder.name

        private fun nothingIn(folder: File): RecordingException {
            val expected = "mav0 with cam0, cam1, imu0, or ${GROUND_TRUTHS.joinToString(" or ")}"
            val inside = folder.listFiles { file ->
                file.resolve("mav0").isDirectory
            }.orEmpty().map(File::getName).sorted()
            val hint = if (inside.isEmpty()) "" else "; there is one in ${inside.joinToString()}"
            return RecordingException(folder, null, expected, "none of them$hint")
        }
    }
}

/** An `imu*` folder: angular velocities (rad/s) and accelerations (m/s^2) in the axes of the sensor. */
internal class RecordedImu(val stamps: LongArray, val gyro: List<DoubleArray>, val accel: List<DoubleArray>) {
    companion object {
        /** @param notes receives sentences on what is left out. */
        fun open(folder: File, notes: MutableList<String>): RecordedImu {
            val rows = CsvTable(folder.resolve("data.csv"), columns = 7).rows(notes)
            return RecordedImu(
                LongArray(rows.size) { rows[it].stampNanos },
                rows.map { row -> DoubleArray(3) { row.number(1 + it) } },
                rows.map { row -> DoubleArray(3) { row.number(4 + it) } },
            )
        }
    }
}
