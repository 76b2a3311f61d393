package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.ProtocolException
import dev.ml2sensors.wire.TimeBodies
import kotlinx.coroutines.delay
import kotlinx.coroutines.runInterruptible
import kotlin.time.Duration.Companion.milliseconds

/** Asks the host for its time over a connection of its own: a dense burst first, then steadily. */
internal class TimeLane(
    private val connection: Connection,
    private val deviceClock: DeviceClock,
    private val hostClock: HostClock,
) {
    /** Runs until the connection fails or the coroutine is cancelled. */
    suspend fun run() {
        var asked = 0
        while (true) {
            runInterruptible { exchange() }
            delay(if (++asked < BURST) BURST_INTERVAL else STEADY_INTERVAL)
        }
    }

    private fun exchange() {
        val t1 = deviceClock.nowNanos()
        connection.writer.write(FrameKind.TIME_REQUEST, TimeBodies.request(t1))
        while (true) {
            val frame = connection.read()
            val t4 = deviceClock.nowNanos()
            if (frame.kind != FrameKind.TIME_REPLY) {
                throw ProtocolException(ErrorCode.UNEXPECTED, "expected TIME_REPLY on the time lane, found ${frame.kind}")
            }
            TimeBodies.exchange(t1, frame.body, t4)?.let { return hostClock.add(it) }
        }
    }

    private companion object {
        // PROTOCOL.md, Time: about 128 requests in 1.2 s, then 20 per second.
        const val BURST = 128
        val BURST_INTERVAL = 9.milliseconds
        val STEADY_INTERVAL = 50.milliseconds
    }
}
