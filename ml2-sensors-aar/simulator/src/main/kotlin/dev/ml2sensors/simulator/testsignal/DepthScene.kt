package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.OPTICAL_IN_BODY
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.rotate
import dev.ml2sensors.message.times
import dev.ml2sensors.source.Intrinsics
import kotlin.math.abs
import kotlin.math.floor
import kotlin.math.sqrt

/**
 * What a time-of-flight camera gets back in one pixel.
 *
 * @property range along the ray, in the metres of the room.
 * @property signal of the light that came back, from 0 to 1 at a distance of 1 m.
 * @property isEdge when part of it comes from behind what the pixel sees.
 */
internal class Echo(val range: Double, val signal: Double, val isEdge: Boolean)

/** The rays of a camera in the middle of the room, turned by [orientation] (body axes). */
internal class DepthScene(lens: Intrinsics, orientation: Quaternion) {
    private val rays = List(3) { FloatArray(lens.width * lens.height) }

    /** Of each pixel, z along the optical axis for 1 m along the ray. */
    val axial = FloatArray(lens.width * lens.height)

    init {
        val toRoom = orientation * OPTICAL_IN_BODY.rotation
        for (pixel in axial.indices) {
            val ray = lens.ray((pixel % lens.width).toDouble(), (pixel / lens.width).toDouble())
            val unit = 1 / sqrt(ray dot ray)
            val (x, y, z) = toRoom.rotate(ray * unit)
            rays[0][pixel] = x.toFloat()
            rays[1][pixel] = y.toFloat()
            rays[2][pixel] = z.toFloat()
            axial[pixel] = unit.toFloat()
        }
    }

    fun echo(pixel: Int, balls: List<Ball>): Echo {
        val ray = Vector3(rays[0][pixel].toDouble(), rays[1][pixel].toDouble(), rays[2][pixel].toDouble())
        return balls.mapNotNull { it.echo(ray) }.minByOrNull { it.range } ?: wall(ray)
    }
}

private fun wall(ray: Vector3): Echo {
    val range = minOf(Room.FRONT / abs(ray.x), Room.SIDE / abs(ray.y), Room.HIGH / abs(ray.z))
    val at = ray * range
    val facing = when {
        abs(at.x) > Room.FRONT - NEAR -> ray.x
        abs(at.y) > Room.SIDE - NEAR -> ray.y
        else -> ray.z
    }
    val tile = floor(at.x * 2 + NEAR) + floor(at.y * 2 + NEAR) + floor(at.z * 2 + NEAR)
    val reflectivity = if (tile % 2 == 0.0) 0.75 else 0.5
    return Echo(range, reflectivity * abs(facing) / (range * range), isEdge = false)
}

/** Metres that rounding cannot reach. */
private const val NEAR = 1e-6

private fun Ball.echo(ray: Vector3): Echo? {
    val along = ray dot center
    val squaredMiss = (center dot center) - along * along
    val squaredRadius = radius * radius
    if (along < 0 || squaredMiss > squaredRadius * EDGE) return null
    val depth = sqrt(maxOf(0.0, squaredRadius - squaredMiss))
    val range = along - depth
    return Echo(range, 0.9 * depth / radius / (range * range), isEdge = squaredMiss > squaredRadius / EDGE)
}

/** A pixel is on the edge of a ball when its ray passes the centre at a squared radius off by less than this factor. */
private const val EDGE = 1.04
