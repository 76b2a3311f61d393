package dev.ml2sensors.android

import android.hardware.Sensor
import android.hardware.SensorManager
import android.os.Handler
import android.os.HandlerThread
import android.os.MessageQueue
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import org.robolectric.annotation.RealObject
import org.robolectric.annotation.Resetter
import org.robolectric.shadow.api.Shadow
import org.robolectric.shadows.SensorBuilder
import org.robolectric.util.ReflectionHelpers
import org.robolectric.util.ReflectionHelpers.ClassParameter
import java.lang.ref.WeakReference
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CountDownLatch
import java.util.concurrent.atomic.AtomicLong

/** The sensors below Android's own SensorManager: stands where its native code is. */
internal class SensorHub(private val sensorManager: SensorManager) {
    /** Lists a sensor after those that are listed. */
    fun add(type: Int, name: String, wakesUp: Boolean = false, isOnChange: Boolean = false): Sensor {
        val all = ReflectionHelpers.getField<MutableList<Sensor>>(sensorManager, "mFullSensorsList")
        val byHandle = ReflectionHelpers.getField<MutableMap<Int, Sensor>>(sensorManager, "mHandleToSensor")
        val sensor = SensorBuilder.newBuilder().setType(
            type,
        ).setName(name).setWakeUpFlag(wakesUp).setMinDelay(4_800).build()
        ReflectionHelpers.setField(sensor, "mHandle", all.size + 1)
        if (isOnChange) ReflectionHelpers.setField(sensor, "mFlags", Sensor.REPORTING_MODE_ON_CHANGE shl 1)
        all += sensor
        byHandle[all.size] = sensor
        return sensor
    }

    /** Lists [sensor] no longer; [list] does again. */
    fun unlist(sensor: Sensor) {
        listed -= sensor
    }

    fun list(sensor: Sensor) {
        if (sensor !in listed) listed += sensor
    }

    private val listed: MutableList<Sensor> get() = ReflectionHelpers.getField(sensorManager, "mFullSensorsList")

    /** The product has stopped reading [sensor], though its listeners may not be unregistered yet. */
    fun leave(sensor: Sensor) = queues.values.filter { sensor in it.enabled }.forEach { it.isLeft = true }

    /**
     * Lets [sensor] measure, on the thread its listener asked for; returns the number of listeners that are read, when
     * all have it.
     */
    fun measure(sensor: Sensor, timestamp: Long, vararg values: Float): Int {
        val listening = queues.values.filter { sensor in it.enabled }
        for (queue in listening) {
            val done = CountDownLatch(1)
            queue.handler.post {
                queue.dispatch(handleOf(sensor), values, timestamp)
                done.countDown()
            }
            done.await()
        }
        return listening.count { !it.isLeft }
    }

    /** The number of queues that listeners have, registered or not. */
    val queueCount: Int get() = queues.size

    /** The registered sensors, with period and longest latency in microseconds. */
    val enabled: Map<Sensor, Pair<Int, Int>> get() = queues.values.flatMap {
        it.enabled.entries
    }.associate { it.toPair() }

    /** The thread that a sensor's listener asked for. */
    fun threadOf(sensor: Sensor): Thread = queues.values.single { sensor in it.enabled }.handler.looper.thread

    private class Queue(private val target: Any, messages: MessageQueue) {
        val enabled: MutableMap<Sensor, Pair<Int, Int>> = ConcurrentHashMap()
        var isLeft = false
        val handler = Handler(
            Thread.getAllStackTraces().keys.filterIsInstance<HandlerThread>().single {
                it.looper?.queue === messages
            }.looper,
        )

        fun dispatch(handle: Int, values: FloatArray, timestamp: Long): Any? =
            ReflectionHelpers.callInstanceMethod(
                target,
                "dispatchSensorEvent",
                ClassParameter.from(Int::class.java, handle),
                ClassParameter.from(FloatArray::class.java, values),
                ClassParameter.from(Int::class.java, SensorManager.SENSOR_STATUS_ACCURACY_HIGH),
                ClassParameter.from(Long::class.java, timestamp),
            )

        fun sensor(handle: Int): Sensor {
            val manager = ReflectionHelpers.getField<Any>(target, "mManager")
            return ReflectionHelpers.getField<Map<Int, Sensor>>(manager, "mHandleToSensor").getValue(handle)
        }
    }

    /** The real one, which may not return. */
    @Implements(SensorManager::class)
    open class RealSensorManager {
        @RealObject
        lateinit var manager: SensorManager

        @Implementation
        fun getSensorList(type: Int): List<Sensor> {
            NeverReturns.pass("SensorManager.getSensorList")
            val typed = ClassParameter.from(Int::class.java, type)
            return Shadow.directlyOn(manager, SensorManager::class.java, "getSensorList", typed)
        }
    }

    /** Named too, or Robolectric would give the next test's manager, which is of this class, the shadow of this one. */
    @Implements(className = "android.hardware.SystemSensorManager")
    class RealSystemSensorManager : RealSensorManager()

    /** The native functions of a listener's queue. */
    @Implements(className = "android.hardware.SystemSensorManager\$BaseEventQueue")
    class NativeQueue {
        companion object {
            @JvmStatic
            @Implementation
            @Suppress("UNUSED_PARAMETER")
            fun nativeInitBaseEventQueue(
                manager: Long,
                queue: WeakReference<*>,
                messages: MessageQueue,
                packageName: String,
                mode: Int,
                opPackageName: String,
            ): Long {
                val handle = handles.incrementAndGet()
                queues[handle] = Queue(checkNotNull(queue.get()), messages)
                return handle
            }

            @JvmStatic
            @Implementation
            fun nativeEnableSensor(queue: Long, handle: Int, periodMicros: Int, latencyMicros: Int): Int {
                NeverReturns.pass("SensorManager.registerListener")
                failure?.let { throw it }
                if (refuses) return FAILED
                val it = queues.getValue(queue)
                it.isLeft = Thread.currentThread() in NeverReturns.givenUp
                it.enabled[it.sensor(handle)] = periodMicros to latencyMicros
                return 0
            }

            @JvmStatic
            @Implementation
            fun nativeDisableSensor(queue: Long, handle: Int): Int {
                NeverReturns.pass("SensorManager.unregisterListener")
                queues.getValue(queue).let { it.enabled.remove(it.sensor(handle)) }
                return 0
            }

            @JvmStatic
            @Implementation
            fun nativeDestroySensorEventQueue(queue: Long) {
                queues.remove(queue)
            }

            @JvmStatic
            @Resetter
            fun reset() {
                NeverReturns.reset()
                queues.clear()
                refuses = false
                failure = null
            }
        }
    }

    companion object {
        private const val FAILED = -1
        private val handles = AtomicLong()
        private val queues = ConcurrentHashMap<Long, Queue>()

        /** The exception that a registration throws. */
        @Volatile
        var failure: RuntimeException? = null

        /** True while sensors do not start. */
        var refuses = false

        private fun handleOf(sensor: Sensor) = ReflectionHelpers.getField<Int>(sensor, "mHandle")
    }
}
