package dev.ml2sensors.message

/**
 * A pose in the headset's own axes: x right, y up, z backward (RUB), for the world and for the object in it, metres. It
 * is a separate type so that it cannot be mistaken for a pose in the axes of ROS.
 *
 * It is inferred, not confirmed on a device, that the poses of the world and depth cameras have these axes.
 *
 * @property position The object's position in the world.
 * @property rotation From the object's axes to those of the world; need not be normalised.
 */
internal data class MlPose(val position: Vector3, val rotation: Quaternion) {
    /** Converts to REP-103 body axes, x forward, y left, z up (FLU), for the world and the object. */
    fun toBody(): Transform = Transform(
        Vector3(-position.z, -position.x, position.y),
        Quaternion(-rotation.z, -rotation.x, rotation.y, rotation.w).normalized(),
    )

    /** Converts a camera's pose to optical axes, z forward, x right, y down (RDF), in a world with body axes. */
    fun toOptical(): Transform = toBody() * OPTICAL_IN_BODY

    /** Converts the pose of a marker, whose axes stay x right, y up, z out of the face, to a world with body axes. */
    fun toMarker(): Transform = toBody() * RUB_IN_BODY

    companion object {
        private val RUB_IN_BODY = Transform(Vector3.ZERO, Quaternion(0.5, -0.5, -0.5, 0.5))

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

/** The pose of an optical frame (RDF) in the body frame (FLU) of the same camera. Source: REP-103, suffix frames. */
internal val OPTICAL_IN_BODY: Transform = Transform(Vector3.ZERO, Quaternion(-0.5, 0.5, -0.5, 0.5))
