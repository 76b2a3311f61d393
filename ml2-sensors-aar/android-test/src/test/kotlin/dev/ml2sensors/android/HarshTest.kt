package dev.ml2sensors.android

import android.app.Application
import kotlinx.coroutines.test.runTest
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import org.robolectric.shadows.ShadowLog
import java.lang.management.BufferPoolMXBean
import java.lang.management.ManagementFactory
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.hours

/**
 * Android's classes with faults at random: every stream comes back, the books balance at any time, and nothing grows.
 * The system properties `harsh.faults` and `harsh.seed` set how many faults there are, and which.
 */
@RunWith(RobolectricTestRunner::class)
@Config(
    sdk = [29],
    manifest = Config.NONE,
    shadows = [
        CameraRig.Manager::class, CameraRig.Device::class, CameraRig.Session::class, CameraRig.Reader::class,
        CameraRig.TaggedResult::class, CameraRig.TaggedTotalResult::class, FakeMulticastLock::class,
        FakeNsdManager::class, SensorHub.NativeQueue::class, SensorHub.RealSensorManager::class,
        SensorHub.RealSystemSensorManager::class, AvcCodec::class, HarshBattery::class, HarshPower::class,
    ],
)
class HarshTest {
    private val app: Application = RuntimeEnvironment.getApplication()
    private val seed = System.getProperty("harsh.seed", "1").toLong()
    private val faults = System.getProperty("harsh.faults", "500").toInt()
    private val random = Random(seed)
    private val begun = mutableListOf<String>()
    private val lasting = mutableMapOf<String, Lasting>()

    private class Lasting(val end: () -> Unit, var ticks: Int)

    /** The resources in use when all faults have ended. */
    private class Usage(val open: Map<String, Int>, val threads: Int, val heapBytes: Long, val directBytes: Long) {
        override fun toString() = "$threads threads, heap of $heapBytes bytes, direct memory of $directBytes bytes"
    }

    @Test
    fun everythingComesBackAndNothingGrows() = runTest(timeout = 12.hours) {
        val headset = HarshHeadset(app, this)
        val usages = mutableListOf<Usage>()
        try {
            headset.start()
            headset.recover()
            val before = headset.open()
            repeat(CHECKS) { check ->
                repeat(faults * (check + 1) / CHECKS - begun.size) { headset.misbehave() }
                headset.mend()
                usages += headset.usage()
                assertEquals(before, usages.last().open, "what is open")
            }
            assertFlat(usages.drop(WARM_UP))
            println("$faults faults, seed $seed: ${usages[WARM_UP]}, in the end ${usages.last()}")
            headset.close()
            if (faults >=
                ENOUGH
            ) {
                assertEquals(NeverReturns.CALLS.toSet(), NeverReturns.seen, "calls that never returned")
            }
            assertEquals(before.mapValues { 0 }, headset.open(), "what is open in the end")
        } catch (e: Throwable) {
            throw AssertionError(
                "seed $seed, after ${begun.size} faults, the last ones ${begun.takeLast(
                    10,
                )}, while ${lasting.keys}: $e",
                e,
            )
        }
    }

    /** Leaves nothing behind for the next test, also after a failure. */
    @After
    fun mendAll() {
        end { true }
        CameraRig.readers.clear()
        AvcCodec.reset()
        SensorHub.NativeQueue.reset()
    }

    private fun HarshHeadset.misbehave() {
        val fault = Fault.ALL.filterNot { it.name in lasting }.random(random)
        begun += fault.name
        fault.begin(this, random)?.let { lasting[fault.name] = Lasting(it, random.nextInt(1, LONGEST_TICKS)) }
        repeat(random.nextInt(1, MOST_TICKS_BETWEEN)) {
            tick()
            lasting.values.forEach { it.ticks-- }
            end { it.ticks <= 0 }
        }
    }

    private fun end(isOver: (Lasting) -> Boolean) {
        val over = lasting.filterValues(isOver)
        lasting -= over.keys
        over.values.forEach { it.end() }
    }

    private fun HarshHeadset.mend() {
        end { true }
        recover()
    }

    private fun HarshHeadset.usage(): Usage {
        platform.poses.forgetCalls()
        ShadowLog.clear()
        repeat(COLLECTIONS) {
            System.gc()
            System.runFinalization()
        }
        val direct = ManagementFactory.getPlatformMXBeans(BufferPoolMXBean::class.java).single { it.name == "direct" }
        val heapBytes = ManagementFactory.getMemoryMXBean().heapMemoryUsage.used
        return Usage(open(), busyThreads(), heapBytes, direct.memoryUsed)
    }

    /** The threads that are not idle in a pool, of which there are more when the machine is busy. */
    private fun busyThreads() =
        Thread.getAllStackTraces().values.count { stack -> stack.none { it.methodName in IDLE_IN_POOL } }

    /** Compares the least of the second half with the least of the first, since what is measured may be garbage, too. */
    private fun assertFlat(usages: List<Usage>) {
        val (first, second) = usages.chunked(usages.size / 2)
        fun growth(amount: (Usage) -> Long) = second.minOf(amount) - first.minOf(amount)
        val measured = usages.joinToString(separator = "\n", prefix = "\n")
        assertTrue(growth { it.threads.toLong() } <= MOST_THREADS, "threads grow: $measured")
        assertTrue(growth { it.heapBytes } <= MOST_HEAP_BYTES, "the heap grows: $measured")
        assertTrue(growth { it.directBytes } <= MOST_DIRECT_BYTES, "the direct memory grows: $measured")
    }

    private companion object {
        const val CHECKS = 20

        /** So many faults reach every call of the platform while it does not return. */
        const val ENOUGH = 2_000

        /** The checks before which classes are loaded and pools are filled. */
        const val WARM_UP = 4
        const val MOST_TICKS_BETWEEN = 6

        /** An object with a finalizer or a cleaner is freed by the collection after the one that finds it. */
        const val COLLECTIONS = 3

        /** Ten seconds. */
        const val LONGEST_TICKS = 40

        /** Where idle threads of ThreadPoolExecutor and of coroutines stand. */
        val IDLE_IN_POOL = setOf("getTask", "tryPark")
        const val MOST_THREADS = 4

        /** With 500 faults and the seeds 1 to 17, the heap grew by 223 kB at most, and the direct memory not at all. */
        const val MOST_HEAP_BYTES = 1_000_000
        const val MOST_DIRECT_BYTES = 1_000_000
    }
}
