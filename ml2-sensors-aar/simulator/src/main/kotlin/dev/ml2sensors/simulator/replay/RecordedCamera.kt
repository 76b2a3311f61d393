package dev.ml2sensors.simulator.replay

import java.io.File
import kotlin.math.roundToInt

/** A `cam*` folder: image files and their times, in order. */
internal class RecordedCamera(val images: List<Image>, val rateHz: Int, private val calibration: CameraCalibration) {
    class Image(val stampNanos: Long, val file: File)

    val intrinsics get() = calibration.intrinsics

    /** The pose of the optical frame in the body frame. */
    val inBody get() = calibration.inBody

    companion object {
        private const val NANOS_PER_SECOND = 1e9

        /** @param notes receives sentences on what is left out or converted. */
        fun open(folder: File, notes: MutableList<String>): RecordedCamera {
            val calibration = CameraCalibration.of(folder)
            val images = images(folder, notes)
            val (width, height) = calibration.intrinsics
            GreyImageDecoder(width, height).otherFormat(images.first().file)?.let {
                notes += "${folder.name}: images of $it are converted to 8-bit grey"
            }
            return RecordedCamera(images, calibration.rateHz ?: rateHz(images), calibration)
        }

        private fun rateHz(images: List<Image>): Int {
            val periods = images.zipWithNext { before, image -> image.stampNanos - before.stampNanos }.sorted()
            val median = periods.getOrNull(periods.size / 2) ?: return 1
            return (NANOS_PER_SECOND / median).roundToInt().coerceAtLeast(1)
        }

        private fun images(folder: File, notes: MutableList<String>): List<Image> {
            val table = folder.resolve("data.csv")
            val data = folder.resolve("data")
            val rows = CsvTable(table, columns = 2).rows(notes)
            val (found, missing) = rows.partition { data.resolve(it.text(1)).isFile }
            if (found.isEmpty()) throw missing.first().error("an image data/${missing.first().text(1)}", "no such file")
            missing.firstOrNull()?.let {
                val count = "${missing.size} of ${rows.size}"
                notes += "$table:${it.line}: no file ${it.text(1)} in data; images left out: $count"
            }
            val listed = rows.mapTo(HashSet()) { it.text(1) }
            val unlisted = data.list().orEmpty().count { it !in listed && !it.startsWith('.') }
            if (unlisted > 0) notes += "$data: files left out because they have no row in data.csv: $unlisted"
            return found.map { Image(it.stampNanos, data.resolve(it.text(1))) }
        }
    }
}
