package dev.ml2sensors.unity

import android.hardware.Sensor
import android.hardware.SensorManager
import dev.ml2sensors.android.FakeKeystore
import dev.ml2sensors.android.HarshContext
import dev.ml2sensors.android.NeverReturns
import dev.ml2sensors.android.SensorHub
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.session.ScriptedHost
import org.junit.After
import org.junit.Before
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.annotation.Config
import java.security.Security
import java.util.concurrent.CountDownLatch
import kotlin.random.Random
import kotlin.test.assertTrue
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.measureTime

/**
 * Closing from Unity's main thread, in random states. Only `make harsh`, which sets `harsh.faults`, holds its time
 * against the limit: a busy machine adds to it.
 */
@RunWith(RobolectricTestRunner::class)
@Config(
    sdk = [29],
    manifest = Config.NONE,
    shadows = [
        SensorHub.RealSensorManager::class, SensorHub.RealSystemSensorManager::class, SensorHub.NativeQueue::class,
    ],
)
class UnityCloseTest {
    private val sensors = RuntimeEnvironment.getApplication().getSystemService(SensorManager::class.java)
    private val hub = SensorHub(sensors).apply { add(Sensor.TYPE_LIGHT, "Ambient Light Sensor") }
    private val measuredFaults = System.getProperty("harsh.faults")?.toInt()

    /** Blocks the listener, as Unity's main thread does while it is blocked itself. */
    @Volatile
    private var listening: CountDownLatch? = null
    private val listener = object : Ml2UnityListener {
        override fun changed(statusJson: String) {
            listening?.await()
        }
    }

    private val keystore = FakeKeystore()

    @Before
    fun addKeystore() {
        keystore.before = { NeverReturns.pass("KeyStore.$it") }
        Security.addProvider(keystore)
    }

    @After
    fun reset() {
        Security.removeProvider(keystore.name)
        SensorHub.NativeQueue.reset()
    }

    @Test
    fun closingReturnsThoughNothingAnswers() {
        val random = Random(System.getProperty("harsh.seed", "1").toLong())
        val took = List((measuredFaults ?: 500) / STATES_SHARE) { closeIn(random) }.sorted()
        if (measuredFaults == null) return
        println("closing in ${took.size} states took ${took.last()} at most, and ${took[took.size / 2]} in the middle")
        assertTrue(took.last() <= LIMIT, "closing took ${took.filter { it > LIMIT }}")
    }

    /** Closes in a state that [random] draws, and returns how long that took. Only then anything answers that did not. */
    private fun closeIn(random: Random): Duration = ScriptedHost().use { silent ->
        ScriptedHost().use { host -> closeIn(random, silent, host) }
    }

    private fun closeIn(random: Random, silent: ScriptedHost, host: ScriptedHost): Duration {
        val answer = CountDownLatch(1)
        val ofOpening = HarshContext.CALLS_OF_OPENING.filter {
            random.nextInt(OPENINGS_SHARE) == 0
        }.map(NeverReturns::hold)
        val unity = Ml2Unity.open(HarshContext(RuntimeEnvironment.getApplication()), listener)
        var session: HostSession? = null
        val ends = ofOpening + NeverReturns.CALLS.filter { random.nextInt(4) == 0 }.map(NeverReturns::hold)
        if (random.nextInt(4) == 0) listening = answer
        repeat(random.nextInt(6)) {
            when (random.nextInt(7)) {
                0 -> unity.start(silent.address.toString(), STREAMS, insecure = true)

                1 -> unity.stop()

                2 -> unity.pause()

                3 -> unity.resume()

                4 -> unity.permissionsNeeded()

                5 -> unity.pair("ml2s://127.0.0.1:1?fp=${"0".repeat(64)}&token=${"0".repeat(32)}")

                else -> if (session == null && listening == null) {
                    unity.start(host.address.toString(), STREAMS, insecure = true)
                    session = host.session(STREAMS)
                }
            }
        }
        val took = measureTime { unity.close() }
        answer.countDown()
        ends.forEach { it() }
        listening = null
        return took
    }

    private companion object {
        const val STREAMS = """{"battery": {}, "light_sensor": {}, "color": {}}"""

        /** Opening waits for some seconds while its calls do not return, which is in one of so many states. */
        const val OPENINGS_SHARE = 20

        val LIMIT = 500.milliseconds

        /** One state for so many faults. */
        const val STATES_SHARE = 20
    }
}
