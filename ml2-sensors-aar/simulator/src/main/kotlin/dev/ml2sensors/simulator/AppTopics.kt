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
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.map
import kotlinx.serialization.KSerializer
import kotlinx.serialization.json.Json
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.security.MessageDigest
import kotlin.time.Duration.Companion.milliseconds

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

/** The option `--subscribe`: a topic of ROS that is printed. */
internal class PrintedTopic(private val topic: String, private val type: String) {
    /**
     * Prints each message of the topic until the streamer ends or the receiver refuses it: as JSON if this program has
     * a class of the type, else in hexadecimal; a long one by its length, or by its length and SHA-256. The last line says
     * how many there were.
     *
     * @throws UsageError if the topic or type is none.
     */
    fun printer(streamer: Ml2Streamer, log: (String) -> Unit): suspend () -> Unit {
        val lines = try {
            lines(streamer)
        } catch (mistake: IllegalArgumentException) {
            throw UsageError("--subscribe: ${mistake.message}")
        }
        return {
            var messages = 0L
            try {
                lines.collect {
                    messages++
                    log(it)
                }
            } catch (refusal: SubscriptionException) {
                log("not subscribed: ${refusal.message}")
            }
            log("$topic: $messages messages")
        }
    }

    private fun lines(streamer: Ml2Streamer): Flow<String> = CLASSES[type]?.let { lines(streamer, it) }
        ?: streamer.subscribe(topic, type, KEEP).map { line(it, it.message.toText()) }

    private fun <T> lines(streamer: Ml2Streamer, serializer: KSerializer<T>): Flow<String> =
        streamer.subscribe(topic, serializer, KEEP).map {
            val text = JSON.encodeToString(serializer, it.message)
            line(it, if (text.length > MOST) "of ${text.length} characters" else text)
        }

    private fun line(received: Received<*>, text: String) =
        "$topic ${received.number} ${received.publishedNanos ?: "unknown"} $text"

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
