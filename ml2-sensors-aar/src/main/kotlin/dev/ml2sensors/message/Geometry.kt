package dev.ml2sensors.message

import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/** A free vector [x], [y], [z]; its unit is that of the property it is the value of. Source: geometry_msgs/msg/Vector3, Jazzy. */
@Serializable
@SerialName("geometry_msgs/msg/Vector3")
public data class Vector3(val x: Double, val y: Double, val z: Double) {
    public companion object {
        /** The zero vector. */
        public val ZERO: Vector3 = Vector3(0.0, 0.0, 0.0)
    }
}

/** A position [x], [y], [z] in metres. Source: geometry_msgs/msg/Point, Jazzy. */
@Serializable
@SerialName("geometry_msgs/msg/Point")
public data class Point(val x: Double, val y: Double, val z: Double)

/**
 * A rotation as a unit quaternion: vector [x], [y], [z], scalar [w]; it and its negation are the same rotation.
 * Source: geometry_msgs/msg/Quaternion, Jazzy.
 */
@Serializable
@SerialName("geometry_msgs/msg/Quaternion")
public data class Quaternion(val x: Double, val y: Double, val z: Double, val w: Double) {
    public companion object {
        /** No rotation. */
        public val IDENTITY: Quaternion = Quaternion(0.0, 0.0, 0.0, 1.0)
    }
}

/** A [position] in metres and an [orientation]. Source: geometry_msgs/msg/Pose, Jazzy. */
@Serializable
@SerialName("geometry_msgs/msg/Pose")
public data class Pose(val position: Point, val orientation: Quaternion)

/** A [pose] in the frame of the [header]. Source: geometry_msgs/msg/PoseStamped, Jazzy. */
@Serializable
@SerialName("geometry_msgs/msg/PoseStamped")
public data class PoseStamped(val header: Header, val pose: Pose)

/** [poses] in the frame of the [header], such as the joints of a hand. Source: geometry_msgs/msg/PoseArray, Jazzy. */
@Serializable
@SerialName("geometry_msgs/msg/PoseArray")
public data class PoseArray(val header: Header, val poses: List<Pose>)

/**
 * The pose of a child frame in its parent. It converts coordinates in the child to coordinates in the parent, rotation
 * first. Source: geometry_msgs/msg/Transform, Jazzy.
 *
 * @property translation The child's origin in the parent, metres.
 * @property rotation The child's axes in the parent.
 */
@Serializable
@SerialName("geometry_msgs/msg/Transform")
public data class Transform(val translation: Vector3, val rotation: Quaternion) {
    public companion object {
        /** No translation and no rotation. */
        public val IDENTITY: Transform = Transform(Vector3.ZERO, Quaternion.IDENTITY)
    }
}

/**
 * One edge of the TF tree. Source: geometry_msgs/msg/TransformStamped, Jazzy.
 *
 * @property header The time the transform is for, and the parent frame.
 * @property childFrameId The frame that it places.
 * @property transform From the child to the parent.
 */
@Serializable
@SerialName("geometry_msgs/msg/TransformStamped")
public data class TransformStamped(val header: Header, val childFrameId: String, val transform: Transform)

/** The [transforms] that are published on `/tf` and `/tf_static`. Source: tf2_msgs/msg/TFMessage, Jazzy. */
@Serializable
@SerialName("tf2_msgs/msg/TFMessage")
public data class TFMessage(val transforms: List<TransformStamped>)
