package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.source.CaptureSettings
import dev.ml2sensors.source.ImageSample
import java.awt.BasicStroke
import java.awt.Color
import java.awt.Font
import java.awt.Graphics2D
import java.awt.RadialGradientPaint
import java.awt.RenderingHints
import java.awt.geom.Ellipse2D
import java.awt.geom.Path2D
import java.awt.geom.Point2D
import java.awt.image.BufferedImage
import kotlin.math.PI
import kotlin.math.cos
import kotlin.math.sin

private const val SIZE = 400

/** Returns the eye camera [stream], which shows a moving eye under infrared light. */
internal fun eyeCamera(stream: String): Camera = Camera(
    SIZE,
    SIZE,
    strideBytes = SIZE,
    mapOf(ImageSample.IMAGE to FrameNumber.MONO8),
    CaptureSettings(exposureNanos = 1_000_000, analogGain = 1.0, digitalGain = 1.0),
) { phase ->
    val image = BufferedImage(SIZE, SIZE, BufferedImage.TYPE_INT_RGB)
    val graphics = image.createGraphics()
    graphics.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON)
    graphics.drawEye(phase, if (stream.contains("nasal") == stream.endsWith("left")) 1 else -1)
    graphics.color = Color.WHITE
    graphics.font = Font(Font.SANS_SERIF, Font.BOLD, 18)
    graphics.drawString(stream, 10, SIZE - 12)
    graphics.dispose()
    listOf(grey(image, brightness = 1.0))
}

/** Draws the eye, seen from [side] 1 or -1. */
private fun Graphics2D.drawEye(phase: Double, side: Int) {
    val gaze = Point2D.Double(200 + side * 20 + 45 * cos(2 * PI * phase), 195 + 22 * sin(4 * PI * phase))
    paint = glow(Point2D.Double(200.0 - side * 60, 170.0), 320.0, Color(0xa0a0a0), Color(0x303030))
    fillRect(0, 0, SIZE, SIZE)
    val lids = lids(side)
    val everything = clip
    clip(lids)
    paint = glow(Point2D.Double(200.0, 200.0), 170.0, Color(0xdcdcdc), Color(0x8a8a8a))
    fill(lids)
    drawIris(gaze, radius = 72.0)
    clip = everything
    color = Color(0x404040)
    stroke = BasicStroke(7f, BasicStroke.CAP_ROUND, BasicStroke.JOIN_ROUND)
    draw(lids)
}

private fun Graphics2D.drawIris(center: Point2D.Double, radius: Double) {
    paint = glow(center, radius, Color(0x989898), Color(0x484848))
    fill(disk(center.x, center.y, radius))
    stroke = BasicStroke(1.4f)
    repeat(90) { spoke ->
        val angle = 2 * PI * spoke / 90
        val length = radius * (0.7 + 0.28 * Scene.noise(spoke, 3))
        color = Color.WHITE.times(0.3 + 0.3 * Scene.noise(spoke, 7))
        val path = Path2D.Double()
        path.moveTo(center.x + 0.4 * radius * cos(angle), center.y + 0.4 * radius * sin(angle))
        path.lineTo(center.x + length * cos(angle), center.y + length * sin(angle))
        draw(path)
    }
    color = Color(0x0a0a0a)
    fill(disk(center.x, center.y, 0.42 * radius))
    color = Color.WHITE
    repeat(6) { lamp ->
        val angle = 2 * PI * lamp / 6 + 0.3
        fill(disk(0.6 * center.x + 80 + 34 * cos(angle), 0.6 * center.y + 80 + 34 * sin(angle), 4.0))
    }
}

private fun lids(side: Int): Path2D = Path2D.Double().apply {
    moveTo(30.0, 205.0 + 20 * side)
    curveTo(110.0, 70.0, 290.0, 70.0, 370.0, 205.0 - 20 * side)
    curveTo(300.0, 300.0, 100.0, 300.0, 30.0, 205.0 + 20 * side)
}

private fun glow(center: Point2D.Double, radius: Double, inner: Color, outer: Color) =
    RadialGradientPaint(center, radius.toFloat(), floatArrayOf(0f, 1f), arrayOf(inner, outer))

private fun disk(x: Double, y: Double, radius: Double) =
    Ellipse2D.Double(x - radius, y - radius, 2 * radius, 2 * radius)
