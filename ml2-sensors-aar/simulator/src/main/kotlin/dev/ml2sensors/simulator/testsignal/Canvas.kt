package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.map
import dev.ml2sensors.source.Intrinsics
import java.awt.BasicStroke
import java.awt.Color
import java.awt.Font
import java.awt.Graphics2D
import java.awt.RadialGradientPaint
import java.awt.RenderingHints
import java.awt.geom.Ellipse2D
import java.awt.geom.Path2D
import java.awt.image.BufferedImage

/** Draws 3D shapes of the scene as a camera sees them. [camera] is the pose of the optical frame in the scene. */
internal class Canvas(image: BufferedImage, private val lens: Intrinsics, camera: Transform) : AutoCloseable {
    private val graphics: Graphics2D = image.createGraphics()
    private val toCamera = camera.inverse()

    init {
        graphics.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON)
        graphics.setRenderingHint(RenderingHints.KEY_TEXT_ANTIALIASING, RenderingHints.VALUE_TEXT_ANTIALIAS_ON)
    }

    fun polygon(color: Color, corners: List<Vector3>) {
        graphics.color = color
        graphics.fill(path(corners) ?: return)
    }

    fun line(color: Color, widthPixels: Double, points: List<Vector3>) {
        graphics.color = color
        graphics.stroke = BasicStroke(widthPixels.toFloat(), BasicStroke.CAP_ROUND, BasicStroke.JOIN_ROUND)
        graphics.draw(path(points) ?: return)
    }

    /** Draws a rectangle of [columns] by [rows] tiles from [corner]. Tiles are small, to follow the lens distortion. */
    fun tiles(
        corner: Vector3,
        along: Vector3,
        up: Vector3,
        columns: Int,
        rows: Int,
        color: (column: Int, row: Int) -> Color,
    ) {
        val right = along * (1.0 / columns)
        val above = up * (1.0 / rows)
        for (row in 0 until rows) {
            for (column in 0 until columns) {
                val at = corner + right * column.toDouble() + above * row.toDouble()
                polygon(color(column, row), listOf(at, at + right, at + right + above, at + above))
            }
        }
    }

    fun sphere(color: Color, sphere: Sphere) {
        val middle = lens.project(toCamera.map(sphere.center)) ?: return
        val top = lens.project(toCamera.map(sphere.center + Vector3(0.0, 0.0, sphere.radius))) ?: return
        val r = middle.distance(top)
        graphics.paint = RadialGradientPaint(
            (middle.x - r / 3).toFloat(),
            (middle.y - r / 3).toFloat(),
            (1.5 * r).toFloat(),
            floatArrayOf(0f, 0.3f, 1f),
            arrayOf(Color.WHITE, color, color.darker().darker().darker()),
        )
        graphics.fill(Ellipse2D.Double(middle.x - r, middle.y - r, 2 * r, 2 * r))
    }

    /** Writes text in the lower left corner of the image. */
    fun label(text: String) {
        graphics.font = Font(Font.SANS_SERIF, Font.BOLD, lens.height / 26)
        val width = graphics.fontMetrics.stringWidth(text)
        val line = graphics.fontMetrics.height
        graphics.color = Color(0, 0, 0, 150)
        graphics.fillRect(0, lens.height - 2 * line, width + 2 * line, 2 * line)
        graphics.color = Color.WHITE
        graphics.drawString(text, line, lens.height - line * 3 / 4)
    }

    override fun close(): Unit = graphics.dispose()

    private fun path(points: List<Vector3>): Path2D? {
        val path = Path2D.Double()
        for (point in points) {
            val pixel = lens.project(toCamera.map(point)) ?: return null
            if (path.currentPoint == null) path.moveTo(pixel.x, pixel.y) else path.lineTo(pixel.x, pixel.y)
        }
        return path.apply { closePath() }
    }
}
