package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.times
import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.ImageSample
import java.awt.image.BufferedImage
import java.awt.image.DataBufferInt

/** Returns the world camera [stream]. At low exposure its images are dark. */
internal fun worldCamera(stream: String, isLowExposure: Boolean): Camera {
    val extrinsics = SENSOR_EXTRINSICS.getValue(stream)
    val exposureNanos = if (isLowExposure) 500_000L else 4_000_000L
    return Camera(
        WORLD_LENS.width,
        WORLD_LENS.height,
        strideBytes = WORLD_LENS.width,
        mapOf(ImageSample.IMAGE to FrameNumber.MONO8),
        CaptureSettings(exposureNanos, analogGain = 2.0, digitalGain = 1.0),
        WORLD_LENS,
        extrinsics,
    ) { phase ->
        val image = BufferedImage(WORLD_LENS.width, WORLD_LENS.height, BufferedImage.TYPE_INT_RGB)
        Canvas(image, WORLD_LENS, Scene.head(phase) * extrinsics * OPTICAL_IN_BODY).use { canvas ->
            Scene.draw(canvas, phase)
            canvas.label(stream)
        }
        listOf(grey(image, if (isLowExposure) 0.2 else 1.0))
    }
}

/** Returns the Rec. 601 luma of a TYPE_INT_RGB [image] times [brightness], one byte per pixel. */
internal fun grey(image: BufferedImage, brightness: Double): ByteArray {
    val pixels = (image.raster.dataBuffer as DataBufferInt).data
    val scale = (brightness * 256).toInt()
    return ByteArray(pixels.size) { index ->
        val rgb = pixels[index]
        val luma = 77 * (rgb shr 16 and 255) + 150 * (rgb shr 8 and 255) + 29 * (rgb and 255)
        (luma * scale shr 16).toByte()
    }
}
