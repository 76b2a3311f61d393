package dev.ml2sensors.clock

import kotlin.math.pow
import kotlin.random.Random

internal const val MICRO = 1_000L
internal const val MILLI = 1_000_000L
internal const val SECOND = 1_000_000_000L

/** The delays of a path in ns, by the instant of sending; packets of one direction do not overtake each other. */
internal class VirtualNetwork(
    val name: String,
    private val outNanos: (Long) -> Long,
    private val backNanos: (Long) -> Long,
) {
    /** One exchange begun at device time [t1], with a host whose clock is ahead by [offset]. */
    fun exchange(t1: Long, offset: (Long) -> Long): TimeExchange {
        val arrived = t1 + outNanos(t1)
        val answered = arrived + HOST_WORK_NANOS
        return TimeExchange(t1, arrived + offset(arrived), answered + offset(answered), answered + backNanos(answered))
    }

    companion object {
        private const val HOST_WORK_NANOS = 20 * MICRO

        /** Loopback, or a quiet cable: a round trip of about 100 us with jitter of 20 us. */
        fun idle(random: Random): VirtualNetwork {
            val delay = { _: Long -> 40 * MICRO + random.nextLong(20 * MICRO) }
            return VirtualNetwork("idle", delay, delay)
        }

        fun symmetric(random: Random): VirtualNetwork {
            val delay = { _: Long -> MILLI + random.nextLong(300 * MICRO) }
            return VirtualNetwork("symmetric", delay, delay)
        }

        fun asymmetric(random: Random): VirtualNetwork {
            val jitter = { random.nextLong(100 * MICRO) }
            return VirtualNetwork("asymmetric constant", { 3 * MILLI + jitter() }, { MILLI + jitter() })
        }

        fun uniform(random: Random): VirtualNetwork {
            val jitter = { random.nextLong(5 * MILLI) }
            return VirtualNetwork("uniform one-sided 5 ms", { MILLI + jitter() }, { MILLI })
        }

        /** Pareto of shape 1.1: its mean is 11 times its median, and one in 10 000 takes half a second. */
        fun heavyTailed(random: Random): VirtualNetwork {
            val tail = { (100 * MICRO * ((1 - random.nextDouble()).pow(-1 / 1.1) - 1)).toLong().coerceAtMost(SECOND) }
            return VirtualNetwork("heavy-tailed one-sided", { MILLI + tail() }, { MILLI })
        }

        /** Every three seconds nothing gets through for half a second, as when a headset scans for access points. */
        fun stalls(random: Random): VirtualNetwork {
            val delay = { at: Long ->
                val stalled = (SECOND / 2 - at % (3 * SECOND)).coerceAtLeast(0)
                stalled + MILLI + random.nextLong(300 * MICRO)
            }
            return VirtualNetwork("stalls of 500 ms", delay, delay)
        }

        /** Images go out at 30 Hz through a link that is busy with them three quarters of the time, in one queue. */
        fun queueing(random: Random): VirtualNetwork {
            var image = 0L
            var idleAt = 0L
            val queue = { at: Long ->
                while (image <= at) {
                    idleAt = maxOf(idleAt, image) + random.nextLong(15 * MILLI, 35 * MILLI)
                    image += SECOND / 30
                }
                maxOf(idleAt - at, 0)
            }
            return VirtualNetwork("queueing", { queue(it) + MILLI + random.nextLong(300 * MICRO) }) {
                MILLI + random.nextLong(300 * MICRO)
            }
        }

        val all: List<(Random) -> VirtualNetwork> =
            listOf(::idle, ::symmetric, ::asymmetric, ::uniform, ::heavyTailed, ::stalls, ::queueing)
    }
}

/** A device and a host in virtual time: exchanges as TimeLane makes them, captures at 60 Hz. */
internal class VirtualTime(private val network: VirtualNetwork, private val offset: (Long) -> Long) {
    var now = 1_000 * SECOND
        private set
    val clock = HostClock { now }
    private var burstUntil = now + 1_200 * MILLI
    private var nextExchange = now
    private var nextCapture = now

    /** Another link begins here. */
    fun linkUp() {
        burstUntil = now + 1_200 * MILLI
        nextExchange = now
    }

    /** Runs to [until]; [linked] exchanges, and tells [capture] each instant of one. */
    fun run(until: Long, linked: Boolean = true, capture: (Long) -> Unit) {
        while (now < until) {
            if (nextExchange > now || !linked) {
                capturesUntil(minOf(until, if (linked) nextExchange else until), capture)
                continue
            }
            val exchange = network.exchange(now, offset)
            capturesUntil(exchange.t4, capture)
            clock.add(exchange)
            nextExchange = maxOf(now, exchange.t1 + if (exchange.t1 < burstUntil) 1_200 * MILLI / 128 else 50 * MILLI)
        }
    }

    private fun capturesUntil(until: Long, capture: (Long) -> Unit) {
        while (nextCapture <= until) {
            now = nextCapture
            if (clock.stamps.isSet) capture(now)
            nextCapture += SECOND / 60
        }
        now = until
    }
}
