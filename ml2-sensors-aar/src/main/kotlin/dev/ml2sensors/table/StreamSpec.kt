package dev.ml2sensors.table

/**
 * One stream: a row of config/streams.yaml, which is configured, accepted or refused as a whole.
 *
 * @property id also the name of its image lane.
 * @property section of config.yaml.
 * @property topics its channels, in the order of the table.
 * @property frameId of its messages.
 * @property bodyFrameId the REP-103 body frame of an optical [frameId], null if the stream has no pose.
 * @property encoding of its image; for JPEG the format as image_transport has it.
 * @property permissions Android permissions that it needs.
 * @property backends that can serve it, the default first.
 * @property modes legal combinations of a camera's values; empty for other sensors.
 * @property showsEyes true if its images are of the wearer's eyes, which are biometric data.
 * @property longestPauseSeconds the longest normal pause between two samples; null if any pause is normal.
 */
public class StreamSpec internal constructor(
    public val id: String,
    public val section: String,
    public val topics: List<TopicSpec> = emptyList(),
    public val frameId: String,
    public val bodyFrameId: String? = null,
    public val encoding: String? = null,
    public val permissions: List<String> = emptyList(),
    public val backends: List<String> = emptyList(),
    public val modes: List<Mode> = emptyList(),
    internal val showsEyes: Boolean = false,
    public val longestPauseSeconds: Int? = null,
) {
    /** True for a camera: a stream with images. */
    public val isCamera: Boolean get() = topics.any { it.laneClass === StreamTable.imageLane }

    override fun toString(): String = id
}

/**
 * One topic of a stream.
 *
 * @property role what it carries: `image`, `camera_info`, `metadata`, `imu`, ...
 * @property name relative to the receiver's prefix, or global with a leading slash.
 * @property type ROS 2 type, such as `sensor_msgs/msg/Image`.
 * @property lane `sensors`, or the stream's id for a lane of its own.
 * @property laneClass what that lane has in common with others.
 * @property qos row of the table's QoS.
 * @property encoding of an image, null for the stream's.
 * @property condition `key=value` of the configuration that switches it on, null when it is always on.
 */
public class TopicSpec internal constructor(
    public val role: String,
    public val name: String,
    public val type: String,
    public val lane: String,
    internal val laneClass: LaneClass,
    public val qos: String,
    public val encoding: String? = null,
    public val condition: String? = null,
)

/**
 * The common values of topics that the app defines.
 *
 * @property small the class of the lane of small messages.
 * @property large the class of the lane of large ones.
 * @property maxTopics the most in one run of the app.
 */
internal class CustomTopicsSpec(
    val role: String,
    val small: LaneClass,
    val large: LaneClass,
    val qos: String,
    val latchedQos: String,
    val maxTopics: Int,
) {
    /** The classes of the lanes, by name. */
    val lanes: Map<String, LaneClass> get() = mapOf(small.name to small, StreamTable.custom.id to large)

    /**
     * Returns the row of the topic [name], which is absolute or the last part of one, with [known] others.
     *
     * @throws IllegalArgumentException if ROS does not allow the name or type.
     * @throws IllegalStateException if there are too many.
     */
    fun topic(
        name: String,
        type: String,
        known: Int,
        isLatched: Boolean = false,
        isLarge: Boolean = false,
    ): TopicSpec {
        val isAbsolute = name.startsWith("/")
        val isName = if (isAbsolute) {
            name.length <= MAX_ABSOLUTE && name.drop(1).split('/').all(NAME::matches)
        } else {
            name.length <= MAX_NAME && NAME.matches(name)
        }
        require(isName) { "no topic of ROS can be named '$name'" }
        require(type.length <= MAX_TYPE && TYPE.matches(type)) {
            "expected a type as std_msgs/msg/Float32, found '$type'"
        }
        check(known < maxTopics) { "an app has at most $maxTopics topics of its own" }
        val fullName = if (isAbsolute) name else "${StreamTable.custom.id}/$name"
        val lane = if (isLarge) StreamTable.custom.id else small.name
        return TopicSpec(role, fullName, type, lane, lanes.getValue(lane), if (isLatched) latchedQos else qos)
    }

    private companion object {
        // As PROTOCOL.md has them
        const val MAX_NAME = 64
        const val MAX_TYPE = 128
        const val MAX_ABSOLUTE = 255
        val NAME = Regex("[A-Za-z](_?[A-Za-z0-9])*")
        val TYPE = Regex("[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*")
    }
}

/**
 * A legal combination of a camera's values.
 *
 * @property stream the device's number of it: 0 or 1.
 * @property formats of the pixels, such as `jpeg`.
 * @property rates in Hz.
 * @property resolutions width to height, pixels.
 */
public class Mode internal constructor(
    public val stream: Int,
    public val formats: List<String>,
    public val rates: List<Int>,
    public val resolutions: List<Pair<Int, Int>>,
)

/**
 * The order in which images give way to the link: each quality of JPEG, with each of them one group of streams after
 * another; then group after group, with each of them one rate after another, in two rounds.
 *
 * @property streams groups of ids.
 * @property firstRoundHz down to which rate each group goes in the first round.
 */
internal class AdaptationSpec(
    val streams: List<List<String>>,
    val qualities: List<Int>,
    val ratesHz: List<Int>,
    val firstRoundHz: List<Int>,
)

/**
 * The common values of the lanes of one purpose.
 *
 * @property isShared true for one lane with this [name]; else each stream with topics on it has a lane with its id.
 * @property isPaced true if it gives way to lanes that are not paced.
 * @property queueFrames the length of the queue in front of a lane; a full queue drops the oldest.
 * @property maxPayloadBytes the longest message on it.
 */
internal class LaneClass(
    val name: String,
    val isShared: Boolean,
    val isPaced: Boolean,
    val queueFrames: Int,
    val maxPayloadBytes: Int,
)
