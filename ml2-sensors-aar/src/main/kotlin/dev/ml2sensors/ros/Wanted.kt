package dev.ml2sensors.ros

import dev.ml2sensors.cdr.layout
import dev.ml2sensors.message.ServiceType
import dev.ml2sensors.wire.ControlJson
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.isShort
import dev.ml2sensors.wire.printable
import kotlinx.serialization.ExperimentalSerializationApi

private const val MOST_IDS = 0xFFFF
private const val MOST_CHARACTERS = 255

/** The messages that a flow is to receive. */
internal sealed interface Wanted {
    /** As people read it. */
    val name: String

    val keep: Keep

    /** Returns the OPEN of number [id] for what has the number [received] or a later one. */
    fun open(id: Int, received: Long): Open
}

/** A topic that a flow is to receive. */
internal class WantedTopic(
    private val topic: String,
    private val type: String,
    layout: String?,
    override val keep: Keep,
    private val maxHz: Double?,
    private val hash: String?,
) : Wanted {
    override val name: String get() = topic
    private val layout: String?

    init {
        requireName("topic", topic)
        require(isShort(type, MOST_CHARACTERS) && TYPE.matches(type)) {
            "expected a ROS type such as std_msgs/msg/String, of a class by its @SerialName, found '$type'"
        }
        requireRate(maxHz)
        require(hash == null || HASH.matches(hash)) {
            "hash: expected RIHS01_ and 64 hexadecimal digits, found '${printable(hash.orEmpty())}'"
        }
        val bytes = ControlJson.encode(Open.serializer(), open(MOST_IDS, MOST_NUMBER, layout)).size
        require(bytes <= FrameKind.OPEN.maxLength || hash != null) {
            "$type has too many fields to be compared by a layout of ${layout?.length} characters: OPEN has room for " +
                "${FrameKind.OPEN.maxLength} bytes, found $bytes. Give its hash, which `ros2 topic info -v` shows"
        }
        this.layout = layout.takeIf { bytes <= FrameKind.OPEN.maxLength }
    }

    override fun open(id: Int, received: Long): Open = open(id, received, layout)

    private fun open(id: Int, received: Long, layout: String?): Open = Open(
        id,
        Open.SUBSCRIPTION,
        topic,
        type,
        hash,
        layout,
        keep = if (keep is Keep.All) "all" else "latest",
        depth = (keep as? Keep.All)?.depth,
        maxHz = maxHz,
        received = received,
    )

    private companion object {
        const val MOST_NUMBER = 0xFFFF_FFFFL
        val TYPE = Regex("[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*")
        val HASH = Regex("RIHS01_[0-9a-f]{64}")
    }
}

/** The pose of [frame] in [reference], which a flow is to receive. */
internal class WantedTransform(
    private val frame: String,
    private val reference: String,
    private val maxHz: Double?,
) : Wanted {
    override val name: String get() = "$frame in $reference"
    override val keep: Keep get() = Keep.Latest

    init {
        requireName("frame", frame)
        requireName("reference", reference)
        requireRate(maxHz)
    }

    override fun open(id: Int, received: Long): Open =
        Open(id, Open.TRANSFORM, maxHz = maxHz, frame = frame, reference = reference)
}

private fun requireName(what: String, name: String) = require(isShort(name, MOST_CHARACTERS)) {
    "$what: expected 1 to $MOST_CHARACTERS printable characters, found '${printable(name)}'"
}

private fun requireRate(maxHz: Double?) = require(maxHz == null || (maxHz > 0 && maxHz.isFinite())) {
    "maxHz: expected more than 0, found $maxHz"
}

/** The layouts of request and response, as in OPEN. */
@OptIn(ExperimentalSerializationApi::class)
internal val ServiceType<*, *>.layout: String
    get() = "${request.descriptor.layout()}>${response.descriptor.layout()}"

/**
 * The name and the type of a service, which the app calls or offers, and what became of its requests. Without a [layout]
 * the receiver cannot compare the types.
 */
internal class NamedService(
    private val kind: String,
    val name: String,
    private val type: String,
    private val layout: String?,
) {
    val book = CallBook()

    init {
        requireName("service", name)
        require(isShort(type, MOST_CHARACTERS) && TYPE.matches(type)) {
            "expected a ROS type such as std_srvs/srv/SetBool, found '${printable(type)}'"
        }
        val bytes = ControlJson.encode(Open.serializer(), open(MOST_IDS)).size
        require(bytes <= FrameKind.OPEN.maxLength) {
            "$type has too many fields: OPEN has room for ${FrameKind.OPEN.maxLength} bytes, found $bytes"
        }
    }

    fun open(id: Int) = Open(id, kind, name, type, layout = layout)

    private companion object {
        val TYPE = Regex("[a-z][a-z0-9_]*/srv/[A-Z][A-Za-z0-9]*")
    }
}
