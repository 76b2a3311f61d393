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
 * When and in which frame a message was measured. Source: std_msgs/msg/Header, Jazzy.
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
