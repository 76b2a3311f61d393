package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.times
import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.ImageSample
import java.awt.image.BufferedImage
import java.awt.image.DataBufferInt

/** A tracking camera of the name [stream]; at low exposure the room is dark. */
internal fun worldCamera(stream: String, isLowExposure: Boolean): Camera {
    val mount = MOUNTS.getValue(stream)
    val exposureNanos = if (isLowExposure) 500_000L else 4_000_000L
    return Camera(
        WORLD_LENS.width,
        WORLD_LENS.height,
        strideBytes = WORLD_LENS.width,
        mapOf(ImageSample.IMAGE to FrameNumber.MONO8),
        CaptureSettings(exposureNanos, analogGain = 2.0, digitalGain = 1.0),
        WORLD_LENS,
        mount,
    ) { phase ->
        val image = BufferedImage(WORLD_LENS.width, WORLD_LENS.height, BufferedImage.TYPE_INT_RGB)
        Canvas(image, WORLD_LENS, Room.head(phase) * mount * OPTICAL_IN_BODY).use { canvas ->
            Room.draw(canvas, phase)
            canvas.label(stream)
        }
        listOf(grey(image, if (isLowExposure) 0.2 else 1.0))
    }
}

/** Rec. 601 luma of a TYPE_INT_RGB [image] times [brightness], one byte per pixel. */
internal fun grey(image: BufferedImage, brightness: Double): ByteArray {
    val pixels = (image.raster.dataBuffer as DataBufferInt).data
    val scale = (brightness * 256).toInt()
    return ByteArray(pixels.size) { index ->
        val rgb = pixels[index]
        val luma = 77 * (rgb shr 16 and 255) + 150 * (rgb shr 8 and 255) + 29 * (rgb and 255)
        (luma * scale shr 16).toByte()
    }
}
