package dev.ml2sensors.simulator

import com.github.ajalt.clikt.core.UsageError
import dev.ml2sensors.message.BatteryState
import dev.ml2sensors.message.Imu
import dev.ml2sensors.message.Joy
import dev.ml2sensors.message.PoseArray
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.message.TFMessage
import dev.ml2sensors.ros.Keep
import dev.ml2sensors.ros.Received
import dev.ml2sensors.ros.SubscriptionException
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.stream.TopicPublisher
import dev.ml2sensors.stream.Will
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.map
import kotlinx.serialization.KSerializer
import kotlinx.serialization.json.Json
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.security.MessageDigest
import kotlin.random.Random
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/** Publishes `custom/app_uptime`, the seconds since this was created, ten times a second: an example of a custom topic. */
internal class AppUptime(streamer: Ml2Streamer, private val clock: DeviceClock) {
    private val publisher = streamer.publisher("app_uptime", "std_msgs/msg/Float64")
    private val startNanos = clock.nowNanos()

    suspend fun run() {
        val message = ByteBuffer.wrap(byteArrayOf(0, 1, 0, 0) + ByteArray(Double.SIZE_BYTES))
        message.order(ByteOrder.LITTLE_ENDIAN)
        while (true) {
            val now = clock.nowNanos()
            message.putDouble(Int.SIZE_BYTES, (now - startNanos) / 1e9)
            publisher.publish(message, now)
            delay(INTERVAL)
        }
    }

    private companion object {
        val INTERVAL = 100.milliseconds
    }
}

/**
 * The option `--publish`: a topic of std_msgs/msg/UInt8MultiArray with [bytes] of data, [rateHz] times a second; at 0 one
 * latched message. Its will, after [silentMillis] unless that is 0, has no data.
 */
internal class PublishedTopic(
    private val topic: String,
    private val bytes: Int,
    private val rateHz: Double,
    private val silentMillis: Long,
) {
    /**
     * Publishes until cancelled, and logs each message that is accepted with its number and the SHA-256 of its data, and
     * each new reason why none is.
     *
     * @throws UsageError if the option's values are none.
     */
    fun publishing(streamer: Ml2Streamer, clock: DeviceClock, log: (String) -> Unit): suspend () -> Unit {
        val publisher = try {
            val will = if (silentMillis == 0L) null else Will(message(ByteArray(0)), silentMillis.milliseconds)
            streamer.publisher(topic, TYPE, isLatched = rateHz == 0.0, isLarge = bytes > SMALL, will)
        } catch (mistake: IllegalArgumentException) {
            throw UsageError("--publish: ${mistake.message}")
        }
        return { publish(publisher, clock, log) }
    }

    private suspend fun publish(publisher: TopicPublisher, clock: DeviceClock, log: (String) -> Unit) {
        var number = 0
        var refusal: String? = null
        while (true) {
            val data = Random(number).nextBytes(bytes)
            if (publisher.publish(message(data), clock.nowNanos())) {
                val hash = MessageDigest.getInstance("SHA-256").digest(data).toHexString()
                log("published $topic ${number++} $hash")
                if (rateHz == 0.0) return
            } else if (publisher.refusal != refusal) {
                refusal = publisher.refusal
                refusal?.let { log("not published: $topic: $it") }
            }
            delay(if (rateHz == 0.0) RETRY else (1 / rateHz).seconds)
        }
    }

    /** The encapsulation, a layout without dimensions and offset, and the data. */
    private fun message(data: ByteArray): ByteBuffer = ByteBuffer.allocate(HEAD_BYTES + data.size)
        .order(ByteOrder.LITTLE_ENDIAN).put(byteArrayOf(0, 1, 0, 0)).putLong(0).putInt(data.size).put(data).flip()

    private companion object {
        const val TYPE = "std_msgs/msg/UInt8MultiArray"
        const val HEAD_BYTES = 16
        const val SMALL = 60_000
        val RETRY = 100.milliseconds
    }
}

/** An option that prints what comes of ROS, by its [name] and what it prints. */
internal abstract class Printed(private val option: String, private val name: String) {
    /**
     * Prints a line of each message until the streamer ends or the receiver refuses them. The last line says how many
     * there were.
     *
     * @throws UsageError if the option's values are none.
     */
    fun printer(streamer: Ml2Streamer, log: (String) -> Unit): suspend () -> Unit {
        val lines = try {
            lines(streamer)
        } catch (mistake: IllegalArgumentException) {
            throw UsageError("$option: ${mistake.message}")
        }
        return {
            var messages = 0L
            try {
                lines.collect {
                    messages++
                    log("$name $it")
                }
            } catch (refusal: SubscriptionException) {
                log("not subscribed: ${refusal.message}")
            }
            log("$name: $messages messages")
        }
    }

    protected abstract fun lines(streamer: Ml2Streamer): Flow<String>
}

/** The option `--transform`: the pose of a frame in another. */
internal class PrintedTransform(private val frame: String, private val reference: String) :
    Printed("--transform", "$frame in $reference") {
    override fun lines(streamer: Ml2Streamer): Flow<String> = streamer.transform(frame, reference).map {
        val (at, turn) = it.pose
        val numbers = listOf(at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w).joinToString(" ")
        "${it.stampNanos} ${it.newestNanos} $numbers"
    }
}

/**
 * The option `--subscribe`: a topic. Its messages are JSON if this program has a class of the type, else in hexadecimal;
 * a long one is printed by its length, or by its length and SHA-256.
 */
internal class PrintedTopic(private val topic: String, private val type: String) : Printed("--subscribe", topic) {
    override fun lines(streamer: Ml2Streamer): Flow<String> = CLASSES[type]?.let { lines(streamer, it) }
        ?: streamer.subscribe(topic, type, KEEP).map { line(it, it.message.toText()) }

    private fun <T> lines(streamer: Ml2Streamer, serializer: KSerializer<T>): Flow<String> =
        streamer.subscribe(topic, serializer, KEEP).map {
            val text = JSON.encodeToString(serializer, it.message)
            line(it, if (text.length > MOST) "of ${text.length} characters" else text)
        }

    private fun line(received: Received<*>, text: String) =
        "${received.number} ${received.publishedNanos ?: "unknown"} $text"

    private fun ByteBuffer.toText(): String {
        if (remaining() <= MOST) return ByteArray(remaining()).also { duplicate().get(it) }.toHexString()
        val hash = MessageDigest.getInstance("SHA-256").apply { update(duplicate()) }.digest().toHexString()
        return "of ${remaining()} bytes, SHA-256 $hash"
    }

    private companion object {
        /** Characters of JSON or bytes that are printed. */
        const val MOST = 500
        val KEEP = Keep.All(depth = 100)
        val JSON = Json { allowSpecialFloatingPointValues = true }
        val CLASSES: Map<String, KSerializer<*>> = listOf(
            StringMessage.serializer(),
            PoseStamped.serializer(),
            PoseArray.serializer(),
            TFMessage.serializer(),
            Imu.serializer(),
            Joy.serializer(),
            BatteryState.serializer(),
        ).associateBy { it.descriptor.serialName }
    }
}
