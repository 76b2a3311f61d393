package dev.ml2sensors.simulator.replay

import java.io.File

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
