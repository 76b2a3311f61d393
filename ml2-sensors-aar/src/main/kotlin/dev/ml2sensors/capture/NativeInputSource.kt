package dev.ml2sensors.capture

import dev.ml2sensors.source.DropReason
import dev.ml2sensors.source.InputSample
import dev.ml2sensors.table.StreamTable
import java.nio.ByteBuffer

/**
 * Buttons, trigger and touchpad of the controller with one backend, 60 times a second, each stamped with the time at
 * which they were read. Samples are [InputSample]s. Flows fail after a second in which no controller is connected.
 *
 * @param suspendedNanos as [dev.ml2sensors.source.Headset.suspendedNanos].
 */
internal class NativeInputSource(
    private val sensorBackend: NativeBackend,
    private val suspendedNanos: () -> Long = { 0 },
) : NativeSource(SENSOR_CODE, sensorBackend, setOf(StreamTable.controllerJoy), "controller input", QUEUED_SAMPLES) {
    /** Never conflicts: no value of the stream changes what is read. */
    override fun conflict(subscription: Subscription, other: Subscription): String? = null

    override fun open(subscriptions: List<Subscription>): OpenSensor = OpenInput(sensorBackend, suspendedNanos)

    internal companion object {
        /** ML2S_SENSOR_CONTROLLER_INPUT. */
        const val SENSOR_CODE = 9

        /** One quarter of a second. */
        private const val QUEUED_SAMPLES = 16
    }
}

/** The open handle of the controller's input; of the thread that makes it. */
private class OpenInput(backend: NativeBackend, suspendedNanos: () -> Long) : OpenSensor {
    private val input = InputBlock()
    private val handle = NativeSettings(
        NativeInputSource.SENSOR_CODE,
        backend.code,
        setOf(StreamTable.controllerJoy).bits(),
    ).open()
    private val schedule = PeriodicTimer(PERIOD_NANOS, Native::now, suspendedNanos)
    private var pollsWithout = 0

    override fun configure(subscriptions: List<Subscription>) = Unit

    override fun deliver(subscriptions: List<Subscription>) {
        val missed = schedule.awaitNext()
        if (missed > 0) subscriptions.forEach { it.queue.countLost(missed, DropReason.SOURCE_LATE) }
        if (!Native.pollInput(handle, input.memory)) return
        val sample = input.sample() ?: return awaitConnection()
        pollsWithout = 0
        subscriptions.forEach { it.queue.offer(sample) }
    }

    private fun awaitConnection() {
        pollsWithout++
        if (pollsWithout > RATE_HZ) throw CaptureException.NotAvailable("no controller is connected")
    }

    override fun close() = Native.close(handle)

    private companion object {
        const val RATE_HZ = 60
        const val PERIOD_NANOS = 1_000_000_000L / RATE_HZ
    }
}

/** The ml2s_input of one poll. C writes it into [memory]; it is read here by the offsets that C reports. */
private class InputBlock {
    val memory: ByteBuffer = structMemory(1, InputLayout.sizeBytes)

    /** Returns a copy of the state, or null if no controller is connected. */
    fun sample(): InputSample? {
        if (!flag(InputLayout.isConnected)) return null
        return InputSample(
            memory.getLong(InputLayout.captureNanos),
            trigger = memory.getFloat(InputLayout.trigger),
            bumper = flag(InputLayout.bumper),
            menu = flag(InputLayout.menu),
            isTouched = flag(InputLayout.isTouched),
            touchX = memory.getFloat(InputLayout.touch),
            touchY = memory.getFloat(InputLayout.touch + Float.SIZE_BYTES),
            force = memory.getFloat(InputLayout.force),
        )
    }

    private fun flag(offset: Int): Boolean = memory.getInt(offset) != 0
}

/** The offsets of the fields of ml2s_input, in bytes. */
private object InputLayout {
    private val offsets = Offsets(Native.inputLayout())
    val sizeBytes = offsets.next()
    val isConnected = offsets.next()
    val captureNanos = offsets.next()
    val trigger = offsets.next()
    val bumper = offsets.next()
    val menu = offsets.next()
    val isTouched = offsets.next()
    val touch = offsets.next()
    val force = offsets.next()

    init {
        offsets.end()
    }
}
