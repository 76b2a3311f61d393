package dev.ml2sensors.session

import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.clock.TimeExchange
import dev.ml2sensors.pacing.ImagePacing
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.wire.FrameKind
import dev.ml2sensors.wire.TimeBodies
import kotlinx.coroutines.delay
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.TimeSource

/**
 * Requests the host's time over a connection of its own: a dense burst first, then at a steady rate. Its round trips
 * show the queue of the link to [pacing].
 */
internal class TimeLane(
    private val connection: Connection,
    private val deviceClock: DeviceClock,
    private val hostClock: HostClock,
    private val pacing: ImagePacing,
) {
    @Volatile
    private var isOver = false

    /** Runs until [finish], or until the connection ends or fails; the control lane reports why. */
    suspend fun run() {
        val joined = TimeSource.Monotonic.markNow()
        while (!isOver) {
            val asked = TimeSource.Monotonic.markNow()
            hostClock.add(blockingIo { pacing.measured(::exchange, ::thereNanos) } ?: return)
            val interval = if (joined.elapsedNow() < BURST) BURST_INTERVAL else STEADY_INTERVAL
            delay(interval - asked.elapsedNow())
        }
    }

    /** Has [run] end after the exchange that is under way, so that no reply meets a closed connection. */
    fun finish() {
        isOver = true
    }

    private fun exchange(): TimeExchange? {
        val t1 = deviceClock.nowNanos()
        connection.writer.write(FrameKind.TIME_REQUEST, TimeBodies.request(t1))
        while (true) {
            val frame = connection.read(REPLY) ?: return null
            val t4 = deviceClock.nowNanos()
            TimeBodies.exchange(t1, frame.body, t4)?.let { return it }
        }
    }

    private fun thereNanos(exchange: TimeExchange?) = exchange?.let(hostClock::thereNanos)

    private companion object {
        val REPLY = setOf(FrameKind.TIME_REPLY)

        // PROTOCOL.md, Time: about 128 requests in 1.2 s, then 50 per second.
        val BURST = 1200.milliseconds
        val BURST_INTERVAL = BURST / 128
        val STEADY_INTERVAL = 20.milliseconds
    }
}
