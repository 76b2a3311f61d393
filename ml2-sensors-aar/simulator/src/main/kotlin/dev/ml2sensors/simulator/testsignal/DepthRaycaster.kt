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
 * The light that a time-of-flight camera receives in one pixel.
 *
 * @property range the distance along the ray in metres.
 * @property signal the intensity; at a distance of 1 m it is from 0 to 1.
 * @property isEdge true if part of the light comes from a surface further away.
 */
internal class Echo(val range: Double, val signal: Double, val isEdge: Boolean)

/** Casts the rays of a camera at the origin of the scene, rotated by [orientation] (body axes). */
internal class DepthRaycaster(lens: Intrinsics, orientation: Quaternion) {
    private val rays = List(3) { FloatArray(lens.width * lens.height) }

    /** For each pixel, the distance along the optical axis of a point 1 m along the ray. */
    val axial = FloatArray(lens.width * lens.height)

    init {
        val toScene = orientation * OPTICAL_IN_BODY.rotation
        for (pixel in axial.indices) {
            val ray = lens.ray((pixel % lens.width).toDouble(), (pixel / lens.width).toDouble())
            val unit = 1 / sqrt(ray dot ray)
            val (x, y, z) = toScene.rotate(ray * unit)
            rays[0][pixel] = x.toFloat()
            rays[1][pixel] = y.toFloat()
            rays[2][pixel] = z.toFloat()
            axial[pixel] = unit.toFloat()
        }
    }

    fun echo(pixel: Int, spheres: List<Sphere>): Echo {
        val ray = Vector3(rays[0][pixel].toDouble(), rays[1][pixel].toDouble(), rays[2][pixel].toDouble())
        return spheres.mapNotNull { it.echo(ray) }.minByOrNull { it.range } ?: wall(ray)
    }
}

private fun wall(ray: Vector3): Echo {
    val range = minOf(Scene.HALF_LENGTH / abs(ray.x), Scene.HALF_WIDTH / abs(ray.y), Scene.HALF_HEIGHT / abs(ray.z))
    val at = ray * range
    val facing = when {
        abs(at.x) > Scene.HALF_LENGTH - NEAR -> ray.x
        abs(at.y) > Scene.HALF_WIDTH - NEAR -> ray.y
        else -> ray.z
    }
    val tile = floor(at.x * 2 + NEAR) + floor(at.y * 2 + NEAR) + floor(at.z * 2 + NEAR)
    val reflectivity = if (tile % 2 == 0.0) 0.75 else 0.5
    return Echo(range, reflectivity * abs(facing) / (range * range), isEdge = false)
}

/** A distance in metres that is larger than any rounding error. */
private const val NEAR = 1e-6

private fun Sphere.echo(ray: Vector3): Echo? {
    val along = ray dot center
    val squaredMiss = (center dot center) - along * along
    val squaredRadius = radius * radius
    if (along < 0 || squaredMiss > squaredRadius * EDGE) return null
    val depth = sqrt(maxOf(0.0, squaredRadius - squaredMiss))
    val range = along - depth
    return Echo(range, 0.9 * depth / radius / (range * range), isEdge = squaredMiss > squaredRadius / EDGE)
}

/** A pixel is on the edge of a sphere if its ray passes the centre at a squared radius off by less than this factor. */
private const val EDGE = 1.04
