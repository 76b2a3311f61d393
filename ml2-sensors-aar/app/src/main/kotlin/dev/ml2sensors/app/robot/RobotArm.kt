package dev.ml2sensors.app.robot

import android.os.SystemClock
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.Time
import dev.ml2sensors.ros.Keep
import dev.ml2sensors.ros.SubscriptionException
import dev.ml2sensors.stream.Ml2Streamer
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.launch
import java.nio.ByteBuffer

/**
 * A sample of poses in both directions: the app shows where a camera of the robot sees a tag, and sends the pose that
 * the arm is to reach. Thread-safe.
 */
internal class RobotArm(private val streamer: Ml2Streamer, scope: CoroutineScope) : AutoCloseable {
    private val publisher = streamer.publisher(TARGET, "geometry_msgs/msg/PoseStamped")

    @Volatile
    private var tag: PoseStamped? = null

    @Volatile
    private var received = 0L

    @Volatile
    private var sent = 0L

    @Volatile
    private var tagReason = ""

    private val following = scope.launch { follow() }

    val status: RobotStatus
        get() = RobotStatus(tag, received, tagReason, sent, publisher.refusal.orEmpty())

    private suspend fun follow() {
        try {
            streamer.subscribe(TAG, PoseStamped.serializer(), Keep.Latest).collect {
                tag = it.message
                received++
            }
        } catch (refused: SubscriptionException) {
            tagReason = refused.message.orEmpty()
        }
    }

    /** Sends the arm to where the tag was seen last. Does nothing before, and while ROS time is not known. */
    fun reach() {
        val seen = tag ?: return
        val nowNanos = SystemClock.elapsedRealtimeNanos()
        val stampNanos = streamer.stampNanos(nowNanos) ?: return
        val target = PoseStamped(Header(Time.ofNanos(stampNanos), seen.header.frameId), seen.pose)
        val payload = ByteBuffer.wrap(Cdr.encodeToByteArray(PoseStamped.serializer(), target))
        if (publisher.publish(payload, nowNanos)) sent++
    }

    override fun close(): Unit = following.cancel()

    companion object {
        const val TAG = "/tag_pose"
        const val TARGET = "/target_pose"
    }
}

/**
 * The status of the sample.
 *
 * @property tag the newest pose of the tag; null before the first one.
 * @property received the number of its poses.
 * @property tagReason why there are none; may be empty.
 * @property sent the number of targets.
 * @property targetReason why the receiver publishes no targets; may be empty.
 */
internal data class RobotStatus(
    val tag: PoseStamped?,
    val received: Long,
    val tagReason: String,
    val sent: Long,
    val targetReason: String,
)
