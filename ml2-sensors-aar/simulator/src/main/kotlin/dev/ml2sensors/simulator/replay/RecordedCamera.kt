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

        /** The accepted ratios of the period to that by the rate. Some data sets leave out many images. */
        private val LIKELY = 0.01..100.0

        /** @param notes receives sentences on what is left out or converted. */
        fun open(folder: File, notes: MutableList<String>): RecordedCamera {
            val calibration = CameraCalibration.of(folder)
            val images = images(folder, notes)
            val (width, height) = calibration.intrinsics
            GreyImageDecoder(width, height).otherFormat(images.first().file)?.let {
                notes += "${folder.name}: images of $it are converted to 8-bit grey"
            }
            val period = periodNanos(images) ?: return RecordedCamera(images, calibration.rateHz ?: 1, calibration)
            val rate = calibration.rateHz ?: (NANOS_PER_SECOND / period).roundToInt().coerceAtLeast(1)
            if (period * rate / NANOS_PER_SECOND !in LIKELY) {
                val expected = "times in ns, ${(NANOS_PER_SECOND / rate).roundToInt()} apart by rate_hz $rate"
                throw RecordingException(folder.resolve("data.csv"), null, expected, "$period apart")
            }
            return RecordedCamera(images, rate, calibration)
        }

        /** The median of the times between images. */
        private fun periodNanos(images: List<Image>): Long? {
            val periods = images.zipWithNext { before, image -> image.stampNanos - before.stampNanos }.sorted()
            return periods.getOrNull(periods.size / 2)
        }

        private fun images(folder: File, notes: MutableList<String>): List<Image> {
            val table = folder.resolve("data.csv")
            val data = folder.resolve("data")
            val rows = CsvTable(table, columns = 2).rows(notes)

            fun file(row: CsvTable.Row): File = row.text(1).let { name ->
                // Some name the image with its folder, or without its ending.
                listOf(name, name.substringAfterLast('/'), "$name.png").map(data::resolve).firstOrNull(File::isFile)
                    ?: data.resolve(name)
            }
            val (found, missing) = rows.partition { file(it).isFile }
            if (found.isEmpty()) throw missing.first().error("an image data/${missing.first().text(1)}", "no such file")
            missing.firstOrNull()?.let {
                val count = "${missing.size} of ${rows.size}"
                notes += "$table:${it.line}: no file ${it.text(1)} in data; images left out: $count"
            }
            val listed = rows.mapTo(HashSet()) { file(it).name }
            val unlisted = data.list().orEmpty().count { it !in listed && !it.startsWith('.') }
            if (unlisted > 0) notes += "$data: files left out because they have no row in data.csv: $unlisted"
            return found.map { Image(it.stampNanos, file(it)) }
        }
    }
}
