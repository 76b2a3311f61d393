package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.Vector3
import dev.ml2sensors.message.times
import kotlin.math.PI
import kotlin.math.cos
import kotlin.math.pow
import kotlin.math.sin
import kotlin.random.Random

/**
 * The motion of the head at one time.
 *
 * @property pose the pose of the head (x forward, y left, z up) in the world.
 * @property acceleration the acceleration in the world, m/s^2, without gravity.
 * @property angularVelocity the angular velocity in the head's axes, rad/s.
 * @property angularAcceleration the angular acceleration in the head's axes, rad/s^2.
 */
internal class HeadState(
    val pose: Transform,
    val acceleration: Vector3,
    val angularVelocity: Vector3,
    val angularAcceleration: Vector3,
)

/** An endless, smooth head motion in closed form. [seed] chooses it. Functions are pure. */
internal class Trajectory(seed: Long) {
    private val random = Random(seed)
    private val x = sines(0.6 to 0.11, 0.03 to 0.7)
    private val y = sines(0.5 to 0.13, 0.03 to 0.8)
    private val z = sines(0.08 to 0.21, 0.015 to 1.6)
    private val yaw = sines(0.5 to 0.15, 0.1 to 0.6)
    private val pitch = sines(0.15 to 0.23, 0.03 to 0.9)
    private val roll = sines(0.08 to 0.19, 0.02 to 1.1)

    fun at(seconds: Double): HeadState {
        val orientation = yaw(yaw.value(seconds)) * pitch(pitch.value(seconds)) * roll(roll.value(seconds))
        return HeadState(
            Transform(Vector3(x.value(seconds), y.value(seconds), z.value(seconds)), orientation),
            Vector3(x.secondDerivative(seconds), y.secondDerivative(seconds), z.secondDerivative(seconds)),
            angularVelocity(seconds),
            (angularVelocity(seconds + STEP) - angularVelocity(seconds - STEP)) * (0.5 / STEP),
        )
    }

    /** Transforms the rates of yaw, pitch and roll to an angular velocity in the head's axes. */
    private fun angularVelocity(seconds: Double): Vector3 {
        val tilt = pitch.value(seconds)
        val lean = roll.value(seconds)
        val yawRate = yaw.derivative(seconds)
        val pitchRate = pitch.derivative(seconds)
        return Vector3(
            roll.derivative(seconds) - yawRate * sin(tilt),
            pitchRate * cos(lean) + yawRate * cos(tilt) * sin(lean),
            yawRate * cos(tilt) * cos(lean) - pitchRate * sin(lean),
        )
    }

    private fun sines(vararg amplitudeToHertz: Pair<Double, Double>) =
        Sines(amplitudeToHertz.map { (amplitude, hertz) -> Sine(amplitude, 2 * PI * hertz, random.nextDouble(2 * PI)) })

    private companion object {
        /** Seconds; central differences over this step are exact to 1e-7 rad/s^2. */
        const val STEP = 1e-4
    }
}

private class Sine(val amplitude: Double, val angularFrequency: Double, val phase: Double)

private class Sines(private val sines: List<Sine>) {
    fun value(t: Double) = sines.sumOf { it.amplitude * sin(it.angularFrequency * t + it.phase) }

    fun derivative(t: Double) =
        sines.sumOf { it.amplitude * it.angularFrequency * cos(it.angularFrequency * t + it.phase) }

    fun secondDerivative(t: Double) =
        sines.sumOf { -it.amplitude * it.angularFrequency.pow(2) * sin(it.angularFrequency * t + it.phase) }
}
