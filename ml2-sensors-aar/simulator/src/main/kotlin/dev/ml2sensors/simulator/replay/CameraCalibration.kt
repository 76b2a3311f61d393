package dev.ml2sensors.simulator.replay

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.inverse
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.Intrinsics
import java.io.File
import kotlin.math.roundToInt

/** A message on the wire holds at most 16 MiB (PROTOCOL.md, Kinds). */
private const val MAX_SIDE_PIXELS = 4095.0

private const val RADTAN = 5

/**
 * The calibration of one camera, as its data set has it.
 *
 * @property rateHz the rate of the camera; null if the data set does not have it.
 * @property inBody the pose of the optical frame in the body frame.
 */
internal class CameraCalibration(val rateHz: Int?, val intrinsics: Intrinsics, val inBody: Transform) {
    companion object {
        /**
         * Reads `sensor.yaml` in the [camera]'s folder `camN`. Without it, reads the data set's file for all cameras:
         * Kalibr's `camchain.yaml`, which TUM-VI has in `dso`, or Basalt's `calibration.json`.
         */
        fun of(camera: File): CameraCalibration {
            val own = camera.resolve("sensor.yaml")
            if (own.isFile) return asl(YamlFile(own))
            val sensors = camera.parentFile
            val dataSet = sensors.absoluteFile.parentFile
            fun file(name: String) = listOf(dataSet, sensors).map { it.resolve(name) }.firstOrNull(File::isFile)
            (file("dso/camchain.yaml") ?: file("camchain.yaml"))?.let { return kalibr(YamlFile(it), camera.name) }
            file("calibration.json")?.let { return basalt(YamlFile(it), camera.name.removePrefix("cam")) }
            val expected =
                "this file, or in $dataSet Kalibr's dso/camchain.yaml or camchain.yaml, or Basalt's calibration.json"
            throw RecordingException(own, null, expected, "none of them")
        }

        private fun asl(yaml: YamlFile): CameraCalibration {
            val rate = if ("rate_hz" in yaml) yaml.number("rate_hz") else null
            if (rate != null && rate <= 0) throw yaml.error("rate_hz", "positive", "$rate")
            val coefficients = if ("distortion_coeffs" in yaml) "distortion_coeffs" else "distortion_coefficients"
            val matrix = if ("T_BS.data" in yaml) "T_BS.data" else "T_BS"
            return CameraCalibration(
                rate?.roundToInt()?.coerceAtLeast(1),
                yaml.pinhole("", coefficients),
                yaml.transform(matrix),
            )
        }

        private fun kalibr(yaml: YamlFile, camera: String): CameraCalibration = CameraCalibration(
            rateHz = null,
            yaml.pinhole("$camera.", "$camera.distortion_coeffs"),
            yaml.transform("$camera.T_cam_imu").inverse(),
        )

        private fun basalt(yaml: YamlFile, index: String): CameraCalibration {
            val camera = "value0.intrinsics.$index"
            val (width, height) = yaml.size("value0.resolution.$index")
            fun values(vararg names: String) = names.map { yaml.number("$camera.intrinsics.$it") }
            val distortion = when (val type = yaml.text("$camera.camera_type")) {
                "kb4" -> yaml.distortion(camera, "equidistant", values("k1", "k2", "k3", "k4"))

                "pinhole" -> yaml.distortion(camera, "none", emptyList())

                "pinhole-radtan8" ->
                    yaml.distortion(camera, "radtan", values("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"))

                else -> throw yaml.error("$camera.camera_type", "kb4, pinhole or pinhole-radtan8", "'$type'")
            }
            val (fx, fy, cx, cy) = values("fx", "fy", "cx", "cy")
            val pose = "value0.T_imu_cam.$index"
            val (px, py, pz) = listOf("px", "py", "pz").map { yaml.number("$pose.$it") }
            val (x, y, z, w) = listOf("qx", "qy", "qz", "qw").map { yaml.number("$pose.$it") }
            val rotation = unitQuaternion(x, y, z, w)
                ?: throw yaml.error(pose, "a unit quaternion qx,qy,qz,qw", "$x,$y,$z,$w")
            val inBody = Transform(Vector3(px, py, pz), rotation)
            return CameraCalibration(null, Intrinsics(width, height, fx, fy, cx, cy, distortion), inBody)
        }

        private fun YamlFile.transform(key: String): Transform =
            rigidTransform(numbers(key, 16)) { error(key, "a rigid transform", it) }

        private fun YamlFile.size(key: String): Pair<Int, Int> {
            val size = numbers(key, 2)
            if (size.any { it % 1 != 0.0 || it !in 1.0..MAX_SIDE_PIXELS }) {
                throw error(key, "integers of 1 to ${MAX_SIDE_PIXELS.toInt()}", "$size")
            }
            return size[0].toInt() to size[1].toInt()
        }

        private fun YamlFile.pinhole(camera: String, coefficients: String): Intrinsics {
            val projection = text("${camera}camera_model")
            if (!projection.equals("pinhole", ignoreCase = true)) {
                throw error("${camera}camera_model", "pinhole", "'$projection'")
            }
            val (width, height) = size("${camera}resolution")
            val (fx, fy, cx, cy) = numbers("${camera}intrinsics", 4)
            val model = text("${camera}distortion_model")
            val values = if (model == "none" && coefficients !in this) emptyList() else numbers(coefficients)
            val distortion = distortion("${camera}distortion_model", model, values, coefficients)
            return Intrinsics(width, height, fx, fy, cx, cy, distortion)
        }

        private fun YamlFile.distortion(
            key: String,
            model: String,
            values: List<Double>,
            coefficients: String = key,
        ): Distortion {
            val count = values.dropLastWhile { it == 0.0 }.size
            return when (model.lowercase()) {
                "none" -> Distortion.PlumbBob(0.0, 0.0, 0.0, 0.0, 0.0)

                "radial-tangential", "radtan", "plumb_bob" -> {
                    if (values.size < 4 || count > RADTAN) {
                        throw error(coefficients, "k1, k2, p1, p2 and, if any, k3 (the others 0)", "$values")
                    }
                    Distortion.PlumbBob(values[0], values[1], values[2], values[3], values.getOrElse(4) { 0.0 })
                }

                "equidistant" -> {
                    if (values.size < 4 || count > 4) throw error(coefficients, "k1, k2, k3, k4", "$values")
                    Distortion.Equidistant(values[0], values[1], values[2], values[3])
                }

                else -> throw error(key, "radial-tangential, equidistant or none", "'$model'")
            }
        }
    }
}
