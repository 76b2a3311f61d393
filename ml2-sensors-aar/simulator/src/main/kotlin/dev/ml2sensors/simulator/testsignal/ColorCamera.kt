package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.times
import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.ImageSample
import java.awt.Color
import java.awt.image.BufferedImage
import java.io.ByteArrayOutputStream
import javax.imageio.ImageIO
import javax.imageio.stream.MemoryCacheImageOutputStream
import kotlin.math.PI
import kotlin.math.cos
import kotlin.math.sin

/** Returns the colour camera; its images include the headset's holograms if [isMixed]. */
internal fun colorCamera(stream: String, width: Int, height: Int, isMixed: Boolean): Camera {
    val extrinsics = SENSOR_EXTRINSICS.getValue("color")
    val lens = colorLens(width, height)
    return Camera(
        width,
        height,
        strideBytes = 0,
        mapOf(ImageSample.IMAGE to FrameNumber.JPEG),
        CaptureSettings(exposureNanos = 8_000_000, analogGain = 1.5, digitalGain = 1.0),
        lens,
        extrinsics,
    ) { phase ->
        val image = BufferedImage(width, height, BufferedImage.TYPE_3BYTE_BGR)
        Canvas(image, lens, Scene.head(phase) * extrinsics * OPTICAL_IN_BODY).use { canvas ->
            Scene.draw(canvas, phase)
            if (isMixed) canvas.drawHologram(phase, lineWidth = height / 200.0)
            canvas.label("$stream ${width}x$height")
        }
        listOf(FrameNumber.withComment(jpeg(image)))
    }
}

/** Draws a ring of plates that rotates about the wearer's viewing direction. */
private fun Canvas.drawHologram(phase: Double, lineWidth: Double) {
    repeat(PLATES) { plate ->
        val angle = 2 * PI * (phase + plate) / PLATES
        val center = Vector3(1.8, 0.55 * cos(angle), 0.1 + 0.35 * sin(angle))
        val across = Vector3(0.0, 0.1, 0.0)
        val up = Vector3(0.0, 0.0, 0.07)
        val corners = listOf(center - across - up, center + across - up, center + across + up, center - across + up)
        polygon(Color(40, 220, 255, 90), corners)
        line(Color(150, 245, 255, 220), lineWidth, corners)
    }
}

private const val PLATES = 8

private fun jpeg(image: BufferedImage): ByteArray {
    val bytes = ByteArrayOutputStream()
    val writer = ImageIO.getImageWritersByFormatName("jpeg").next()
    try {
        MemoryCacheImageOutputStream(bytes).use { stream ->
            writer.output = stream
            writer.write(image)
        }
    } finally {
        writer.dispose()
    }
    return bytes.toByteArray()
}
