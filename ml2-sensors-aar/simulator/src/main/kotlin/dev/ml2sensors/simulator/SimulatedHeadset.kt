package dev.ml2sensors.simulator

import dev.ml2sensors.capture.NativeBackend
import dev.ml2sensors.capture.NativeHeadsetClock
import dev.ml2sensors.capture.NativePixelSource
import dev.ml2sensors.capture.NativePoseSource
import dev.ml2sensors.capture.PixelSensor
import dev.ml2sensors.capture.PoseSensor
import dev.ml2sensors.simulator.signal.SignalSource
import dev.ml2sensors.simulator.simulated.NativeBundle
import dev.ml2sensors.simulator.simulated.Opening
import dev.ml2sensors.simulator.simulated.SimulatedCamera2
import dev.ml2sensors.simulator.simulated.SimulatedKey
import dev.ml2sensors.simulator.simulated.SimulatedSdk
import dev.ml2sensors.simulator.simulated.sensorManagerSignals
import dev.ml2sensors.simulator.testsignal.battery
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.filter
import java.util.concurrent.atomic.AtomicBoolean

/**
 * A Magic Leap 2 that is a program: the headset's own code, with the very native library of the Android package, on a
 * simulation of the vendor's library. All sensors belong to one walk through one rendered room. What Android would
 * deliver (inertial units, light, colour camera, battery) comes from the same room.
 *
 * It runs on Linux on x86-64, and needs neither Android nor any setting of the environment. The picture of a camera is
 * drawn when its stream is first collected, which takes some seconds; no stream delivers before all cameras that were
 * started together are drawn.
 *
 * All functions are thread-safe.
 */
public class SimulatedHeadset private constructor(private val headset: Headset) : Headset by headset {
    private val opening = Opening(headset.clock, SimulatedSdk::isDrawing)

    override val holds: Map<String, String>
        get() = if (opening.isHolding) StreamTable.all.associate { it.id to "drawing the pictures" } else emptyMap()

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        headset.samples(stream, values).filter { opening.isOver() }

    /**
     * Changes the simulation from now on, such as `set("fault.world.stalled", "1")`: the world cameras deliver nothing
     * until the value is 0 again. `ml2-headset --simulate help` lists all keys.
     *
     * @throws IllegalArgumentException for an unknown key or a wrong value, with what is expected.
     */
    public fun set(key: String, value: String) {
        SimulatedSdk.set(key, value)?.let { throw IllegalArgumentException(it) }
    }

    /** Ends all flows. Another headset can be opened then. */
    override fun close() {
        headset.close()
        isOpen.set(false)
    }

    /** Opens simulated headsets. */
    public companion object {
        private val isOpen = AtomicBoolean()

        /**
         * Opens the simulated headset. One is open at a time in a process. Keys that [settings] does not name have their
         * defaults.
         *
         * @param seed chooses the room, the walk and all noise.
         * @param settings keys of the simulation and their values, as [set] takes them. The key `cache` names a folder
         * that keeps drawn pictures for later runs.
         * @throws IllegalArgumentException for an unknown key or a wrong value, with what is expected.
         * @throws IllegalStateException while another simulated headset is open.
         * @throws UnsatisfiedLinkError where the native code does not run.
         */
        @JvmStatic
        @JvmOverloads
        public fun open(seed: Long = 1, settings: Map<String, String> = emptyMap()): SimulatedHeadset {
            check(isOpen.compareAndSet(false, true)) { "a simulated headset is open already: close it first" }
            try {
                NativeBundle.load()
                val changed = SimulatedKey.all().filter { it.value != it.default }.associate { it.name to it.default }
                val identity = Headset.Identity("simulated-$seed", "Simulated headset, seed $seed")
                val headset = SimulatedHeadset(SensorHeadset(identity, NativeHeadsetClock, sources()))
                (changed + ("seed" to "$seed") + settings).forEach(headset::set)
                return headset
            } catch (e: Throwable) {
                isOpen.set(false)
                throw e
            }
        }
    }
}

/** As on the device, but for what Android would deliver. */
private fun sources(): List<SensorSource> =
    listOf(PixelSensor.WORLD, PixelSensor.DEPTH, PixelSensor.EYE).map { NativePixelSource(it, NativeBackend.SDK) } +
        PoseSensor.entries.map { NativePoseSource(it, NativeBackend.SDK) } +
        PixelSensor.entries.map { NativePixelSource(it, NativeBackend.OPENXR) } +
        PoseSensor.entries.map { NativePoseSource(it, NativeBackend.OPENXR) } +
        SimulatedCamera2() +
        SignalSource("sensor_manager", NativeHeadsetClock, sensorManagerSignals()) +
        SignalSource("battery_manager", NativeHeadsetClock, mapOf(StreamTable.battery to battery()))
