package dev.ml2sensors.simulator

import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.stream.Ml2Streamer
import kotlinx.coroutines.delay
import java.nio.ByteBuffer
import java.nio.ByteOrder
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
