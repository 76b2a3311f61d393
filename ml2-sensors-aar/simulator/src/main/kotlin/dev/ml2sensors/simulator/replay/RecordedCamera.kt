package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Transform
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics
import java.io.File

/**
 * A `cam*` folder: 8-bit grey PNG files and their times, in order.
 *
 * @property inBody the pose of the optical frame in the body frame (`T_BS`).
 */
internal class RecordedCamera(
    val images: List<Image>,
    val rateHz: Int,
    val intrinsics: Intrinsics,
    val inBody: Transform,
) {
    class Image(val stampNanos: Long, val file: File)

    companion object {
        /** A message on the wire holds at most 16 MiB (PROTOCOL.md, Kinds). */
        private const val MAX_SIDE_PIXELS = 4095.0

        fun open(folder: File): RecordedCamera {
            val yaml = SensorYaml(folder.resolve("sensor.yaml"))
            return RecordedCamera(
                images(folder),
                yaml.int("rate_hz").also { if (it <= 0) throw yaml.error("rate_hz", "positive", "$it") },
                intrinsics(yaml),
                extrinsics(yaml),
            )
        }

        private fun images(folder: File): List<Image> =
            CsvTable(folder.resolve("data.csv"), columns = 2).rows().map { row ->
                val file = folder.resolve("data").resolve(row.text(1))
                if (!file.isFile) throw row.error("an image data/${row.text(1)}", "no such file")
                Image(row.stampNanos, file)
            }

        private fun intrinsics(yaml: SensorYaml): Intrinsics {
            yaml.expect("camera_model", "pinhole")
            yaml.expect("distortion_model", "radial-tangential")
            val size = yaml.numbers("resolution", 2)
            if (size.any { it % 1 != 0.0 || it !in 1.0..MAX_SIDE_PIXELS }) {
                throw yaml.error("resolution", "integers of 1 to ${MAX_SIDE_PIXELS.toInt()}", "$size")
            }
            val (fx, fy, cx, cy) = yaml.numbers("intrinsics", 4)
            val (k1, k2, p1, p2) = yaml.numbers("distortion_coefficients", 4)
            val distortion = Distortion.PlumbBob(k1, k2, p1, p2, k3 = 0.0)
            return Intrinsics(size[0].toInt(), size[1].toInt(), fx, fy, cx, cy, distortion)
        }

        private fun SensorYaml.expect(key: String, value: String) {
            if (text(key) != value) throw error(key, value, "'${text(key)}'")
        }
    }
}
