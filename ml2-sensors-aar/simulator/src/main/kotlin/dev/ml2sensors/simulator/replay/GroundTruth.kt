package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.interpolate
import java.io.File

/** The poses of the body in the world. */
internal class GroundTruth(val stamps: LongArray, val poses: List<Transform>) {
    /** Returns the pose at [stampNanos], interpolated between two rows, or null outside the recorded time. */
    fun poseAt(stampNanos: Long): Transform? {
        val found = stamps.binarySearch(stampNanos)
        if (found >= 0) return poses[found]
        val after = -found - 1
        if (after == 0 || after == stamps.size) return null
        val elapsed = (stampNanos - stamps[after - 1]).toDouble()
        return poses[after - 1].interpolate(poses[after], elapsed / (stamps[after] - stamps[after - 1]))
    }

    companion object {
        /**
         * Reads time, position and quaternion (w first). Ignores further columns, such as EuRoC's velocity and biases.
         *
         * @param notes receives sentences on what is left out.
         */
        fun open(folder: File, notes: MutableList<String>): GroundTruth {
            val rows = CsvTable(folder.resolve("data.csv"), columns = 8).rows(notes)
            return GroundTruth(LongArray(rows.size) { rows[it].stampNanos }, rows.map(::pose))
        }

        private fun pose(row: CsvTable.Row): Transform {
            val (px, py, pz, w) = (1..4).map(row::number)
            val (x, y, z) = (5..7).map(row::number)
            val rotation =
                unitQuaternion(x, y, z, w) ?: throw row.error("a unit quaternion w,x,y,z", "$w,$x,$y,$z")
            return Transform(Vector3(px, py, pz), rotation)
        }
    }
}
