package dev.ml2sensors.ros

import dev.ml2sensors.message.Point
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.Quaternion
import dev.ml2sensors.wire.Failure
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.PoseBody
import dev.ml2sensors.wire.printable
import java.io.IOException

/**
 * A message of a ROS topic.
 *
 * @property message as its class, or its bytes.
 * @property publishedNanos when its writer published it, in ROS time; null if unknown.
 * @property number counts up in a topic, with gaps, from 0 to 4294967295 and then from 0 again.
 */
public data class Received<out T>(
    public val message: T,
    public val publishedNanos: Long?,
    public val number: Long,
)

/**
 * The pose of one frame in another, from the transforms of /tf and /tf_static.
 *
 * @property pose the position in m, and a unit quaternion.
 * @property stampNanos the newest time for which all transforms between the frames are known, in ROS time; null if none
 * of them moves.
 * @property newestNanos the stamp of the moving transform that is the oldest: this shows how stale the pose is. Null if
 * none moves.
 */
public data class StampedPose(
    public val pose: Pose,
    public val stampNanos: Long?,
    public val newestNanos: Long?,
) {
    internal companion object {
        fun of(frame: Frame): StampedPose {
            val body = PoseBody.parse(frame.body)
            val (x, y, z) = body.numbers
            val rotation = body.numbers.drop(POSITION)
            val pose = Pose(Point(x, y, z), Quaternion(rotation[0], rotation[1], rotation[2], rotation[POSITION]))
            val (stamp, newest) = listOf(frame.header.captureNanos, body.newestNanos).map { if (it == 0L) null else it }
            return StampedPose(pose, stamp, newest)
        }

        private const val POSITION = 3
    }
}

/** The messages of a topic that wait for a collector that is slower than the topic. */
public sealed interface Keep {
    /** The newest one alone. */
    public data object Latest : Keep

    /** The newest [depth], 1 to 100. */
    public data class All(
        public val depth: Int = 10,
    ) : Keep {
        init {
            require(depth in 1..MOST) { "depth: expected 1 to $MOST, found $depth" }
        }

        private companion object {
            const val MOST = 100
        }
    }
}

/** A subscription has ended, or did not begin, for a [reason] of the receiver. */
public class SubscriptionException private constructor(public val reason: Reason, message: String) :
    IOException(message) {
    /** The reason why a subscription has ended. */
    public enum class Reason(internal val code: String?) {
        /** The receiver serves no subscriptions: only `ml2-receiver run` with ROS does. */
        NOT_SERVED(null),

        /** `app.subscribe` of the receiver's configuration does not have the topic. */
        NOT_ALLOWED("rules"),

        /** ROS does not allow the topic's name. */
        WRONG_NAME("name"),

        /** The receiver does not have the type, or the topic has another. */
        UNKNOWN_TYPE("type"),

        /** The class does not have the fields of the ROS type, in their order. */
        OTHER_LAYOUT("layout"),

        /** 64 subscriptions are open. */
        TOO_MANY("busy"),

        /** Any other reason, which the message says. */
        OTHER(null),
    }

    internal companion object {
        /** @param code why, as in OPENED and CLOSED. */
        fun of(topic: String, code: String?, why: String): SubscriptionException {
            val reason = Reason.entries.firstOrNull { it.code != null && it.code == code } ?: Reason.OTHER
            return SubscriptionException(reason, printable("$topic: $why"))
        }

        fun notServed(topic: String): SubscriptionException =
            SubscriptionException(Reason.NOT_SERVED, "$topic: the receiver serves no subscriptions: $WHICH_DOES")
    }
}

/** A call of a service has no response, for a [reason]. */
public class ServiceException internal constructor(public val reason: Reason, message: String) : IOException(message) {
    /** The reason why a call has no response. */
    public enum class Reason(internal val code: String?) {
        /** No node offers the service, or its node is gone. */
        UNAVAILABLE("unavailable"),

        /** The response did not come in time. The service may have done what it was asked to do. */
        TIMEOUT("timeout"),

        /** The receiver does not let the app call the service, which the message explains. */
        REFUSED("refused"),

        /** The receiver or the app cannot read the other's bytes. */
        MALFORMED("malformed"),

        /** The request, or the response, has more than 64 KiB. */
        TOO_LARGE("too_large"),

        /** 16 calls of the client, or 64 of the app, are under way. */
        BUSY("busy"),

        /**
         * There was no connection, or it was lost before the response. The service may have done what it was asked to
         * do.
         */
        LINK_DOWN("link_down"),

        /** Any other reason, which the message says. */
        OTHER(null),
    }

    internal companion object {
        fun of(service: String, failure: Failure): ServiceException {
            val reason = Reason.entries.firstOrNull { it.code == failure.code } ?: Reason.OTHER
            return ServiceException(reason, printable("$service: ${failure.message}"))
        }

        fun linkDown(service: String, why: String): ServiceException =
            ServiceException(Reason.LINK_DOWN, "$service: $why")
    }
}

internal const val WHICH_DOES = "`ml2-receiver run` does, not with --no-ros; `record` and older versions do not"
