package dev.ml2sensors.simulator.replay

import java.awt.image.BufferedImage
import java.awt.image.DataBufferByte
import java.io.File
import javax.imageio.ImageIO

/** Writes a small valid EuRoC recording for a test to read or damage: [IMAGES] images of 5x3 pixels per camera. */
internal class SyntheticRecording(val folder: File) {
    init {
        camera("cam0")
        camera("cam1")
        val imu = (0 until 10).map { "${FIRST + it * 5_000_000L},0.$it,-1,2e-3,9.8$it,0,-0.$it" }
        write("imu0/data.csv", "#timestamp,w,w,w,a,a,a", imu)
        val poses = (0 until 4).map { "${FIRST - 7 + it * 50_000_000L},$it,2,3,${QUATERNIONS[it]},0,0,0,0,0,0,0,0,0" }
        write("state_groundtruth_estimate0/data.csv", "#time,p,p,p,q,q,q,q,v,v,v,b,b,b,b,b,b", poses)
    }

    fun file(path: String): File = folder.resolve("mav0").resolve(path)

    fun replace(path: String, old: String, new: String) {
        val text = file(path).readText()
        check(old in text) { "'$old' is not in $path" }
        file(path).writeText(text.replaceFirst(old, new))
    }

    fun open(): EurocRecording = EurocRecording.open(folder)

    private fun camera(name: String) {
        file("$name/data").mkdirs()
        file("$name/sensor.yaml").writeText(SENSOR_YAML)
        write("$name/data.csv", "#timestamp [ns],filename", (0 until IMAGES).map { "${stamp(it)},${stamp(it)}.png" })
        repeat(IMAGES) { writePng(file("$name/data/${stamp(it)}.png"), pixels(it)) }
    }

    private fun write(path: String, header: String, rows: List<String>) {
        file(path).parentFile.mkdirs()
        file(path).writeText((listOf(header) + rows).joinToString("\r\n", postfix = "\r\n"))
    }

    companion object {
        const val FIRST = 1_403_715_273_262_142_976L
        const val IMAGES = 3
        const val WIDTH = 5
        const val HEIGHT = 3

        /** w, x, y, z. */
        val QUATERNIONS = listOf("1,0,0,0", "0.8,0.6,0,0", "-0.6,0,0.8,0", "0.5,0.5,-0.5,0.5")

        val SENSOR_YAML =
            """
            %YAML:1.0
            # comment
            T_BS:
              cols: 4
              rows: 4
              data: [0.0, -1.0, 0.0, 0.25,
                     1.0,  0.0, 0.0, -0.5,
                     0.0,  0.0, 1.0, 2.0,
                     0.0, 0.0, 0.0, 1.0]
            rate_hz: 20
            resolution: [5, 3]
            camera_model: pinhole
            intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
            distortion_model: radial-tangential
            distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
            """.trimIndent()

        fun stamp(image: Int): Long = FIRST + image * 50_000_128L

        fun pixels(image: Int) = ByteArray(WIDTH * HEIGHT) { (image * 100 + it * 17).toByte() }

        fun writePng(file: File, pixels: ByteArray, width: Int = WIDTH, type: Int = BufferedImage.TYPE_BYTE_GRAY) {
            val image = BufferedImage(width, pixels.size / width, type)
            if (type == BufferedImage.TYPE_BYTE_GRAY) pixels.copyInto((image.raster.dataBuffer as DataBufferByte).data)
            ImageIO.write(image, "png", file)
        }
    }
}
