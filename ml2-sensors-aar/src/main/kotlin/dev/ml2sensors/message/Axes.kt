package dev.ml2sensors.message

/**
 * A pose in the headset's own axes, as its interfaces give it: x right, y up, z backward (RUB), for the world as for
 * what is in it, metres. A type of its own so that it cannot be mistaken for one in the axes of ROS.
 *
 * That the poses of the world and depth cameras have these axes is inferred, not yet seen on a device.
 *
 * @property position Of the thing in the world.
 * @property rotation From the axes of the thing to those of the world; need not be normalised.
 */
internal data class MlPose(val position: Vector3, val rotation: Quaternion) {
    /** The same in REP-103 body axes, x forward, y left, z up (FLU), for the world as for the thing. */
    fun toBody(): Transform = Transform(
        Vector3(-position.z, -position.x, position.y),
        Quaternion(-rotation.z, -rotation.x, rotation.y, rotation.w).normalized(),
    )

    /** The same for a camera in optical axes, z forward, x right, y down (RDF), in a world with body axes. */
    fun toOptical(): Transform = toBody() * OPTICAL_IN_BODY

    companion object {
        /** The inverse of [toBody]. */
        fun ofBody(body: Transform): MlPose {
            val (x, y, z) = body.translation
            val q = body.rotation
            return MlPose(Vector3(-y, z, -x), Quaternion(-q.y, q.z, -q.x, q.w))
        }

        /** The inverse of [toOptical]. */
        fun ofOptical(optical: Transform): MlPose = ofBody(optical * OPTICAL_IN_BODY.inverse())
    }
}

/** An optical frame (RDF) in the body frame (FLU) of the same camera. Source: REP-103, suffix frames. */
public val OPTICAL_IN_BODY: Transform = Transform(Vector3.ZERO, Quaternion(-0.5, 0.5, -0.5, 0.5))
