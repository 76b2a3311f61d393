package dev.ml2sensors.source

/**
 * A camera's projection for images of [width] x [height] pixels: focal lengths [fx], [fy] and principal point
 * ([cx], [cy]) in pixels of that size, raster origin at the top left; [distortion] of the lens.
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
    /** Returns the intrinsics for another image size: K scales, distortion does not. */
    public fun scaledTo(width: Int, height: Int): Intrinsics {
        val sx = width.toDouble() / this.width
        val sy = height.toDouble() / this.height
        return copy(width = width, height = height, fx = fx * sx, fy = fy * sy, cx = cx * sx, cy = cy * sy)
    }
}

/** Lens distortion; [name] is CameraInfo.distortion_model, where ROS has that model. */
public sealed class Distortion(public val name: String) {
    /** The coefficients in the order of CameraInfo.d. */
    public abstract val coefficients: List<Double>

    /** Brown-Conrady: radial [k1], [k2], [k3], tangential [p1], [p2] (sensor_msgs/distortion_models). */
    internal data class PlumbBob(val k1: Double, val k2: Double, val p1: Double, val p2: Double, val k3: Double) :
        Distortion("plumb_bob") {
        override val coefficients: List<Double> get() = listOf(k1, k2, p1, p2, k3)
    }

    /** theta_d = theta (1 + [k1] theta^2 + [k2] theta^4 + [k3] theta^6 + [k4] theta^8) (Kannala-Brandt). */
    internal data class Equidistant(val k1: Double, val k2: Double, val k3: Double, val k4: Double) :
        Distortion("equidistant") {
        override val coefficients: List<Double> get() = listOf(k1, k2, k3, k4)
    }

    /**
     * The device's world cameras, which ROS has no model for: [Equidistant] by [k1], [k2], [k3], [k4], and the point
     * (x, y) that it gives is moved by (2 [p1] x y + [p2] (r^2 + 2 x^2), [p1] (r^2 + 2 y^2) + 2 [p2] x y),
     * r^2 = x^2 + y^2. CameraInfo has the nearest model of ROS instead.
     */
    internal data class FisheyeTangential(
        val k1: Double,
        val k2: Double,
        val k3: Double,
        val k4: Double,
        val p1: Double,
        val p2: Double,
    ) : Distortion("fisheye_tangential") {
        override val coefficients: List<Double> get() = listOf(k1, k2, k3, k4, p1, p2)
    }
}
