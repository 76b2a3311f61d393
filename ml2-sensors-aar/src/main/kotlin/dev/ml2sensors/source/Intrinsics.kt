package dev.ml2sensors.source

/**
 * A camera's projection for images of [width] x [height] pixels: focal lengths and principal point in pixels of that
 * size, raster origin at the top left.
 */
public data class Intrinsics(
    val width: Int,
    val height: Int,
    val fx: Double,
    val fy: Double,
    val cx: Double,
    val cy: Double,
    val distortion: Distortion,
) {
    /** The same camera for another image size: K scales, distortion does not. */
    public fun scaledTo(width: Int, height: Int): Intrinsics {
        val sx = width.toDouble() / this.width
        val sy = height.toDouble() / this.height
        return copy(width = width, height = height, fx = fx * sx, fy = fy * sy, cx = cx * sx, cy = cy * sy)
    }
}

/** Lens distortion in a model ROS knows; [rosName] is CameraInfo.distortion_model. */
public sealed class Distortion(public val rosName: String) {
    public abstract val coefficients: List<Double>

    /** Brown-Conrady in ROS order (sensor_msgs/distortion_models). */
    public data class PlumbBob(val k1: Double, val k2: Double, val p1: Double, val p2: Double, val k3: Double) :
        Distortion("plumb_bob") {
        override val coefficients: List<Double> get() = listOf(k1, k2, p1, p2, k3)
    }

    /** theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8) (Kannala-Brandt). */
    public data class Equidistant(val k1: Double, val k2: Double, val k3: Double, val k4: Double) :
        Distortion("equidistant") {
        override val coefficients: List<Double> get() = listOf(k1, k2, k3, k4)
    }
}
