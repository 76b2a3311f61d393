package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.map
import dev.ml2sensors.message.rotate
import dev.ml2sensors.message.times
import java.awt.Color
import kotlin.math.PI
import kotlin.math.abs
import kotlin.math.cos
import kotlin.math.sin

internal class Sphere(val center: Vector3, val radius: Double)

/** The room that all cameras show: x forward, y left, z up from the wearer's position; metres. */
internal object Scene {
    const val HALF_LENGTH = 3.5
    const val HALF_WIDTH = 3.0
    const val HALF_HEIGHT = 1.4

    private val HOOK = Vector3(2.6, -1.3, HALF_HEIGHT)
    private const val SPHERE_RADIUS = 0.28

    /** A ball that bounces twice in a [phase] from 0 to 1, while it crosses the room and returns. */
    private fun bouncing(phase: Double) = Sphere(
        Vector3(
            2.3 + 0.3 * cos(2 * PI * phase),
            0.9 * sin(2 * PI * phase),
            -HALF_HEIGHT + SPHERE_RADIUS + 1.3 * abs(sin(2 * PI * phase + 0.5)),
        ),
        SPHERE_RADIUS,
    )

    /** A lamp that swings from [HOOK] once in a [phase] from 0 to 1. */
    private fun lamp(phase: Double): Sphere {
        val angle = 0.45 * sin(2 * PI * phase)
        return Sphere(HOOK + Vector3(0.0, sin(angle), -cos(angle)) * 0.9, 0.16)
    }

    fun spheres(phase: Double): List<Sphere> = listOf(lamp(phase), bouncing(phase))

    /** The pose of the wearer's head, which sways once in a [phase] from 0 to 1. */
    fun head(phase: Double) = Transform(
        Vector3(0.0, 0.08 * sin(2 * PI * phase), 0.03 * cos(2 * PI * phase)),
        yaw(0.06 * sin(2 * PI * phase)) * roll(0.02 * cos(2 * PI * phase)),
    )

    /** Returns a pseudo-random number from 0 to 1. */
    fun noise(a: Int, b: Int): Double {
        var hash = a * 374_761_393 + b * 668_265_263
        hash = (hash xor (hash ushr 13)) * 1_274_126_177
        return ((hash xor (hash ushr 16)) and 0xffff) / 65_535.0
    }

    fun draw(canvas: Canvas, phase: Double) {
        canvas.drawWalls()
        canvas.drawFurniture()
        canvas.drawCube(phase)
        canvas.line(Color(0x303030), 3.0, listOf(HOOK, lamp(phase).center))
        canvas.sphere(Color(0xf2d060), lamp(phase))
        canvas.sphere(Color(0xd64830), bouncing(phase))
    }
}

private val LEFT = Vector3(0.0, 2 * Scene.HALF_WIDTH, 0.0)
private val UP = Vector3(0.0, 0.0, 2 * Scene.HALF_HEIGHT)
private val AHEAD = Vector3(2 * Scene.HALF_LENGTH, 0.0, 0.0)

private fun corner(x: Int, y: Int, z: Int) = Vector3(x * Scene.HALF_LENGTH, y * Scene.HALF_WIDTH, z * Scene.HALF_HEIGHT)

private fun Canvas.drawWalls() {
    tiles(corner(-1, -1, -1), AHEAD, LEFT, 14, 12) { i, j ->
        Color(if ((i + j) % 2 == 0) 0x9c7f5c else 0x6e5338).shaded(i, j)
    }
    tiles(corner(-1, -1, 1), AHEAD, LEFT, 14, 12) { i, j -> Color(0xd8d8d2).shaded(i + 40, j) }
    tiles(corner(1, -1, -1), LEFT, UP, 12, 6) { i, j -> Color(0xb9ad94).shaded(i + 80, j) }
    tiles(corner(-1, 1, -1), AHEAD, UP, 14, 6) { i, j -> Color(0x8fa3b3).shaded(i + 120, j) }
    tiles(corner(-1, -1, -1), AHEAD, UP, 14, 6) { i, j -> Color(0xa69a9f).shaded(i + 160, j) }
}

private fun Canvas.drawFurniture() {
    val wall = Scene.HALF_LENGTH - 0.02
    tiles(Vector3(wall, 0.3, -0.3), Vector3(0.0, 1.2, 0.0), Vector3(0.0, 0.0, 1.2), 8, 8) { i, j ->
        if ((i + j) % 2 == 0) Color(0x101010) else Color(0xf0f0f0)
    }
    tiles(Vector3(wall, -1.8, -0.2), Vector3(0.0, 1.3, 0.0), Vector3(0.0, 0.0, 0.9), 13, 9) { i, j ->
        Color.getHSBColor(((i + 2 * j) / 30f), 0.55f, (0.5 + 0.45 * Scene.noise(i, j)).toFloat())
    }
    val side = Scene.HALF_WIDTH - 0.02
    tiles(Vector3(1.0, side, -0.2), Vector3(1.8, 0.0, 0.0), Vector3(0.0, 0.0, 1.2), 6, 4) { i, j ->
        if (i % 3 == 0) Color(0xf4f4f0) else Color(0x7db7e8 + 0x0a0600 * j)
    }
    tiles(Vector3(0.8, -side, -1.2), Vector3(2.0, 0.0, 0.0), Vector3(0.0, 0.0, 1.9), 20, 4) { i, j ->
        Color.getHSBColor(Scene.noise(i, j + 9).toFloat(), 0.6f, (0.35 + 0.5 * Scene.noise(i + 50, j)).toFloat())
    }
}

private fun Canvas.drawCube(phase: Double) {
    val cube = Transform(Vector3(2.2, 1.2, -0.5), yaw(2 * PI * phase) * roll(0.6))
    for (face in CUBE) {
        val outward = cube.rotation.rotate(face.outward)
        val isHidden = (outward dot cube.map(face.outward)) > 0
        val light = 0.35 + 2.6 * abs(outward.x)
        if (!isHidden) polygon(Color(0x359a6e).times(light), face.corners.map(cube::map))
    }
}

private class Face(val outward: Vector3, u: Vector3, v: Vector3) {
    val corners = listOf(outward + u + v, outward + u - v, outward - u - v, outward - u + v)
}

/** 0.5 m wide. */
private val CUBE: List<Face> = run {
    val x = Vector3(0.25, 0.0, 0.0)
    val y = Vector3(0.0, 0.25, 0.0)
    val z = Vector3(0.0, 0.0, 0.25)
    listOf(
        Face(x, y, z),
        Face(x * -1.0, y, z),
        Face(y, z, x),
        Face(y * -1.0, z, x),
        Face(z, x, y),
        Face(z * -1.0, x, y),
    )
}

private fun Color.shaded(a: Int, b: Int) = times(0.86 + 0.28 * Scene.noise(a, b))

internal fun Color.times(factor: Double) = Color(
    (red * factor).toInt().coerceIn(0, 255),
    (green * factor).toInt().coerceIn(0, 255),
    (blue * factor).toInt().coerceIn(0, 255),
)
