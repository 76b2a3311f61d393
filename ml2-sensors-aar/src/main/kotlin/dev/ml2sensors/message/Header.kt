package dev.ml2sensors.message

import kotlinx.serialization.KSerializer
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable

/** The ROS 2 type of a message class, such as `sensor_msgs/msg/Image`: its serial name. */
internal val KSerializer<*>.rosType: String get() = descriptor.serialName

/**
 * A point in time, as nanoseconds since the Unix epoch in two parts. Source: builtin_interfaces/msg/Time, Jazzy.
 *
 * @property sec Whole seconds, rounded down.
 * @property nanosec Nanoseconds since then, below 1,000,000,000.
 */
@Serializable
@SerialName("builtin_interfaces/msg/Time")
public data class Time(val sec: Int, val nanosec: UInt) {
    /** Returns nanoseconds since the Unix epoch. */
    public fun toNanos(): Long = sec * NANOS_PER_SECOND + nanosec.toLong()

    public companion object {
        private const val NANOS_PER_SECOND = 1_000_000_000L

        /**
         * Returns the time [nanos] nanoseconds after the Unix epoch.
         *
         * @throws IllegalArgumentException if the seconds do not fit 32 bits.
         */
        public fun ofNanos(nanos: Long): Time {
            val sec = Math.floorDiv(nanos, NANOS_PER_SECOND)
            require(sec == sec.toInt().toLong()) { "Expected a time whose seconds fit 32 bits, but found $nanos ns" }
            return Time(sec.toInt(), Math.floorMod(nanos, NANOS_PER_SECOND).toUInt())
        }
    }
}

/**
 * The time and the frame of a measurement. Source: std_msgs/msg/Header, Jazzy.
 *
 * @property stamp Capture time in ROS time.
 * @property frameId The TF frame the message's values refer to.
 */
@Serializable
@SerialName("std_msgs/msg/Header")
public data class Header(val stamp: Time, val frameId: String)

/** Text, such as a JSON document, in [data]. Source: std_msgs/msg/String, Jazzy. */
@Serializable
@SerialName("std_msgs/msg/String")
public data class StringMessage(val data: String)

/**
 * A type of ROS services, with classes of its request [Q] and its response [A] as [dev.ml2sensors.cdr.Cdr] describes
 * them. An app makes one for its own type as the objects of this file do.
 *
 * @property name the ROS type, such as `std_srvs/srv/SetBool`.
 */
public open class ServiceType<Q, A>(
    public val name: String,
    internal val request: KSerializer<Q>,
    internal val response: KSerializer<A>,
)

/** Turns something on or off. Source: std_srvs/srv/SetBool, Jazzy. */
public object SetBool : ServiceType<SetBool.Request, SetBool.Response>(
    "std_srvs/srv/SetBool",
    Request.serializer(),
    Response.serializer(),
) {
    /** @property data true turns it on. */
    @Serializable
    @SerialName("std_srvs/srv/SetBool_Request")
    public data class Request(val data: Boolean)

    /**
     * @property success true if it was done.
     * @property message for people, such as why not.
     */
    @Serializable
    @SerialName("std_srvs/srv/SetBool_Response")
    public data class Response(val success: Boolean, val message: String)
}

/** Begins something that needs no parameters. Source: std_srvs/srv/Trigger, Jazzy. */
public object Trigger : ServiceType<Trigger.Request, Trigger.Response>(
    "std_srvs/srv/Trigger",
    Request.serializer(),
    Response.serializer(),
) {
    /** Has no fields. */
    @Serializable
    @SerialName("std_srvs/srv/Trigger_Request")
    public data object Request

    /**
     * @property success true if it was done.
     * @property message for people, such as why not.
     */
    @Serializable
    @SerialName("std_srvs/srv/Trigger_Response")
    public data class Response(val success: Boolean, val message: String)
}
