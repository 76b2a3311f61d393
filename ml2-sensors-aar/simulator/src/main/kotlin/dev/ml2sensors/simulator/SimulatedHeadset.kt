package dev.ml2sensors.simulator

import dev.ml2sensors.capture.NativeBackend
import dev.ml2sensors.capture.NativeHeadsetClock
import dev.ml2sensors.capture.NativePixelSource
import dev.ml2sensors.capture.NativeReadingSource
import dev.ml2sensors.capture.PixelSensor
import dev.ml2sensors.simulator.signal.SignalSource
import dev.ml2sensors.simulator.simulated.AndroidOtherwise
import dev.ml2sensors.simulator.simulated.NativeBundle
import dev.ml2sensors.simulator.simulated.SimulatedCamera2
import dev.ml2sensors.simulator.simulated.SimulatedSdk
import dev.ml2sensors.simulator.simulated.SimulatedVideoEncoders
import dev.ml2sensors.simulator.simulated.SimulationKey
import dev.ml2sensors.simulator.simulated.batteryManagerSignals
import dev.ml2sensors.simulator.simulated.sensorManagerSignals
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.filter
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.atomic.AtomicBoolean

/**
 * A simulated Magic Leap 2. It runs the headset's own code, including the native library of the Android package, on a
 * simulation of the vendor's library. All sensors follow one trajectory through one rendered scene, including those
 * that Android delivers on a headset (inertial units, light, colour camera, battery).
 *
 * It runs on Linux on x86-64, and needs neither Android nor environment variables. Each frame of a camera is rendered
 * when it is first shown. A camera leaves out captures that fall due meanwhile; they have no frame number and are no lost
 * samples, and the process writes their sum to stderr.
 *
 * Thread-safe.
 */
public class SimulatedHeadset private constructor(private val headset: Headset) : Headset by headset {
    @Volatile
    private var silent = emptySet<StreamSpec>()
    private val otherwise = ConcurrentHashMap<AndroidOtherwise, String>()

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer =
        otherwise.entries.firstOrNull { (fact, value) -> value.isNotEmpty() && fact.concerns(stream, requested) }
            ?.let { (fact, value) -> Answer.Refused(fact.reason(value)) }
            ?: headset.negotiate(stream, requested)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        headset.samples(stream, values).filter { stream !in silent }

    /**
     * Sets a key of the simulation. For example, after `set("fault.world.stalled", "1")` the world cameras deliver
     * nothing until the value is 0 again. `ml2-headset --simulate help` lists all keys.
     *
     * @throws IllegalArgumentException for an unknown key or a wrong value; the message says what was expected.
     */
    public fun set(key: String, value: String) {
        val fact = AndroidOtherwise.entries.find { it.key.name == key }
        if (key == SimulationKey.silent.name) {
            silent = streams(value)
        } else if (fact != null) {
            otherwise[fact] = value
        } else {
            SimulatedSdk.set(key, value)?.let { throw IllegalArgumentException(it) }
        }
    }

    private fun streams(ids: String): Set<StreamSpec> = ids.split(',').filter(String::isNotEmpty).map {
        requireNotNull(StreamTable.byId(it)) { "${SimulationKey.silent.name}: there is no stream \"$it\"" }
    }.toSet()

    /** Ends all flows. Then another simulated headset can be opened. */
    override fun close() {
        headset.close()
        isOpen.set(false)
    }

    /** Opens simulated headsets. */
    public companion object {
        private val isOpen = AtomicBoolean()

        /**
         * Opens the simulated headset. Only one can be open at a time in a process. Keys that [settings] does not name
         * have their defaults.
         *
         * @param seed chooses the scene, the trajectory and all noise.
         * @param settings keys of the simulation and their values, as [set] takes them. The key `cache` names a folder
         * that keeps rendered frames for later runs.
         * @throws IllegalArgumentException for an unknown key or a wrong value; the message says what was expected.
         * @throws IllegalStateException while another simulated headset is open.
         * @throws UnsatisfiedLinkError if the native code does not run on this machine.
         */
        @JvmStatic
        @JvmOverloads
        public fun open(seed: Long = 1, settings: Map<String, String> = emptyMap()): SimulatedHeadset {
            check(isOpen.compareAndSet(false, true)) { "a simulated headset is already open: close it first" }
            try {
                NativeBundle.load()
                val changed = SimulationKey.all().filter { it.value != it.default }.associate { it.name to it.default }
                val identity = Headset.Identity("simulated-$seed", "Simulated headset, seed $seed")
                val headset = SimulatedHeadset(
                    SensorHeadset(identity, NativeHeadsetClock, sources(), SimulatedVideoEncoders),
                )
                (changed + ("seed" to "$seed") + settings).forEach(headset::set)
                return headset
            } catch (e: Throwable) {
                isOpen.set(false)
                throw e
            }
        }
    }
}

/** Returns the sources of a headset, with simulations in place of Android's. */
private fun sources(): List<SensorSource> =
    listOf(PixelSensor.WORLD, PixelSensor.DEPTH, PixelSensor.EYE).map { NativePixelSource(it, NativeBackend.SDK) } +
        NativeReadingSource.all(NativeBackend.SDK) +
        PixelSensor.entries.map { NativePixelSource(it, NativeBackend.OPENXR) } +
        NativeReadingSource.all(NativeBackend.OPENXR) +
        SimulatedCamera2() +
        SignalSource("sensor_manager", NativeHeadsetClock, sensorManagerSignals()) +
        SignalSource("battery_manager", NativeHeadsetClock, batteryManagerSignals())
