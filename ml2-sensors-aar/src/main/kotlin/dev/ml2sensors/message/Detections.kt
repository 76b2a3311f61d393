package dev.ml2sensors.message

import dev.ml2sensors.cdr.FixedLength
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/**
 * A [pose] and how sure it is. Source: geometry_msgs/msg/PoseWithCovariance, Jazzy.
 *
 * @property covariance 6x6, row-major, of x, y, z in metres and the turns about these axes in rad; 0 means unknown.
 */
@Serializable
@SerialName("geometry_msgs/msg/PoseWithCovariance")
internal class PoseWithCovariance(val pose: Pose, @FixedLength(36) val covariance: DoubleArray)

/** A class that a detection may be of, and the [score] of that, 0 to 1. Source: vision_msgs/msg/ObjectHypothesis, 4.1.1. */
@Serializable
@SerialName("vision_msgs/msg/ObjectHypothesis")
internal class ObjectHypothesis(val classId: String, val score: Double)

/** A [hypothesis] and the [pose] that goes with it. Source: vision_msgs/msg/ObjectHypothesisWithPose, 4.1.1. */
@Serializable
@SerialName("vision_msgs/msg/ObjectHypothesisWithPose")
internal class ObjectHypothesisWithPose(val hypothesis: ObjectHypothesis, val pose: PoseWithCovariance)

/** A box about its [center]; [size] is in metres along its axes. Source: vision_msgs/msg/BoundingBox3D, 4.1.1. */
@Serializable
@SerialName("vision_msgs/msg/BoundingBox3D")
internal class BoundingBox3D(val center: Pose, val size: Vector3)

/**
 * One detected object. Source: vision_msgs/msg/Detection3D, 4.1.1.
 *
 * @property results What it may be.
 * @property bbox The box around it.
 * @property id The same for the same object in all messages.
 */
@Serializable
@SerialName("vision_msgs/msg/Detection3D")
internal class Detection3D(
    val header: Header,
    val results: List<ObjectHypothesisWithPose>,
    val bbox: BoundingBox3D,
    val id: String,
)

/** All [detections] of one instant. Source: vision_msgs/msg/Detection3DArray, 4.1.1. */
@Serializable
@SerialName("vision_msgs/msg/Detection3DArray")
internal class Detection3DArray(val header: Header, val detections: List<Detection3D>)
