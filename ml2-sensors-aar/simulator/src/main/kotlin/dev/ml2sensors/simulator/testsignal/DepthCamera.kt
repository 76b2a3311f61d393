package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.StreamValues
import java.nio.ByteBuffer
import java.nio.ByteOrder

/**
 * Returns the depth camera. Distances are in metres along the optical axis, or along the ray if `radial`, and NaN where
 * invalid. `confidence` is the intensity of the returned light; `flags` say why a pixel is invalid. In short range the
 * scene is scaled to a quarter.
 */
internal fun depthCamera(values: StreamValues): Camera {
    val scale = if (values.stream == SHORT_RANGE) 0.25 else 1.0
    val scene = DepthRaycaster(DEPTH_LENS, SENSOR_EXTRINSICS.getValue("depth").rotation)
    val planes = buildMap {
        put(ImageSample.IMAGE, FrameNumber.FLOAT32)
        if (values.confidence == true) put(CONFIDENCE, FrameNumber.FLOAT32)
        if (values.flags == true) put(FLAGS, FrameNumber.INT32)
    }
    return camera(values, planes, illumination = null) { phase ->
        val echoes = scene.echoes(phase)
        planes.keys.map { role ->
            image { out, pixel ->
                val echo = echoes[pixel]
                val metres = scale * echo.range * if (values.radial == true) 1f else scene.axial[pixel]
                when (role) {
                    CONFIDENCE -> out.putFloat((COUNTS * echo.signal).toFloat())
                    FLAGS -> out.putInt(echo.flags)
                    else -> out.putFloat(if (echo.flags == 0) metres.toFloat() else Float.NaN)
                }
            }
        }
    }
}

/** Returns the infrared camera: the depth camera's image under its illuminator, in counts. */
internal fun infraredCamera(values: StreamValues): Camera {
    val scene = DepthRaycaster(DEPTH_LENS, SENSOR_EXTRINSICS.getValue("depth").rotation)
    return camera(values, mapOf(ImageSample.IMAGE to FrameNumber.FLOAT32), illumination = "on") { phase ->
        val echoes = scene.echoes(phase)
        listOf(image { out, pixel -> out.putFloat((AMBIENT_COUNTS + COUNTS * echoes[pixel].signal).toFloat()) })
    }
}

private const val SHORT_RANGE = 1
private const val CONFIDENCE = "confidence"
private const val FLAGS = "flags"

private const val COUNTS = 1000
private const val AMBIENT_COUNTS = 8

/** The smallest signal that gives a valid distance. */
private const val LOW_SIGNAL = 0.012

/** The MLDepthCameraDepthFlags of a pixel: 0, or bit 0 (invalid) with bit 3 (low signal) or bit 4 (flying pixel). */
private val Echo.flags: Int
    get() = when {
        isEdge -> 0b10001
        signal < LOW_SIGNAL -> 0b01001
        else -> 0
    }

private fun DepthRaycaster.echoes(phase: Double): List<Echo> {
    val spheres = Scene.spheres(phase)
    return axial.indices.map { echo(it, spheres) }
}

private fun image(put: (out: ByteBuffer, pixel: Int) -> Unit): ByteArray {
    val pixels = DEPTH_LENS.width * DEPTH_LENS.height
    val out = ByteBuffer.allocate(pixels * Float.SIZE_BYTES).order(ByteOrder.LITTLE_ENDIAN)
    for (pixel in 0 until pixels) put(out, pixel)
    return out.array()
}

private fun camera(
    values: StreamValues,
    planes: Map<String, FrameNumber>,
    illumination: String?,
    draw: (phase: Double) -> List<ByteArray>,
) = Camera(
    DEPTH_LENS.width,
    DEPTH_LENS.height,
    strideBytes = DEPTH_LENS.width * Float.SIZE_BYTES,
    planes,
    CaptureSettings(if (values.stream == SHORT_RANGE) 375_000 else 1_600_000, illumination = illumination),
    DEPTH_LENS,
    SENSOR_EXTRINSICS.getValue("depth"),
    draw,
)
