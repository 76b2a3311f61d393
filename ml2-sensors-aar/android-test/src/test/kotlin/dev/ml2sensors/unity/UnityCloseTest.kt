package dev.ml2sensors.unity

import android.hardware.Sensor
import android.hardware.SensorManager
import dev.ml2sensors.android.SensorHub
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.session.ScriptedHost
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import java.util.concurrent.CountDownLatch
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.measureTime

/** Closing from Unity's main thread, whatever the headset, its sensors and the receiver do. */
@RunWith(RobolectricTestRunner::class)
@Config(
    sdk = [29],
    manifest = Config.NONE,
    shadows = [SensorHub.RealSensorManager::class, SensorHub.NativeQueue::class],
)
class UnityCloseTest {
    private val sensors = RuntimeEnvironment.getApplication().getSystemService(SensorManager::class.java)
    private val hub = SensorHub(sensors).apply { add(Sensor.TYPE_LIGHT, "Ambient Light Sensor") }
    private val states = System.getProperty("unity.states", "20").toInt()

    /** Blocks the listener, as Unity's main thread does while it is blocked itself. */
    private var listening: CountDownLatch? = null
    private val listener = object : Ml2UnityListener {
        override fun changed(statusJson: String) {
            listening?.await()
        }
    }

    @After
    fun reset(): Unit = SensorHub.NativeQueue.reset()

    @Test
    fun closingReturnsWithinHalfASecondInEveryState() {
        val seed = System.getProperty("unity.seed", "1").toLong()
        val random = Random(seed)
        val slow = (1..states).filterNot { closesInTime(random) }
        assertEquals(emptyList(), slow, "of $states states by seed $seed")
    }

    private fun closesInTime(random: Random): Boolean = ScriptedHost().use { host ->
        val answer = CountDownLatch(1)
        val unity = Ml2Unity.open(RuntimeEnvironment.getApplication(), listener)
        var session: HostSession? = null
        if (random.nextBoolean()) SensorHub.hanging = answer
        if (random.nextInt(4) == 0) listening = answer
        repeat(random.nextInt(6)) {
            when (random.nextInt(6)) {
                0 -> unity.start(host.address.toString(), STREAMS, insecure = true)

                1 -> unity.stop()

                2 -> unity.pause()

                3 -> unity.resume()

                4 -> unity.pair("ml2s://127.0.0.1:1?fp=${"0".repeat(64)}&token=${"0".repeat(32)}")

                else -> if (session == null && listening == null) {
                    unity.start(host.address.toString(), STREAMS, insecure = true)
                    session = host.awaitHello().apply {
                        welcome(host.received())
                        configure(1, STREAMS)
                        start(1)
                    }
                }
            }
        }
        val took = measureTime { unity.close() }
        answer.countDown()
        SensorHub.hanging = null
        listening = null
        took <= LIMIT
    }

    private companion object {
        const val STREAMS = """{"battery": {}, "light_sensor": {}}"""

        /** The promise, and what a busy machine may add. */
        val LIMIT = 500.milliseconds + 1500.milliseconds
    }
}
