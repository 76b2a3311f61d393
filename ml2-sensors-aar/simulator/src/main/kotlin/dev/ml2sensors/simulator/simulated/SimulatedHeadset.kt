package dev.ml2sensors.simulator.simulated

import dev.ml2sensors.capture.NativeBackend
import dev.ml2sensors.capture.NativeHeadsetClock
import dev.ml2sensors.capture.NativeLibrary
import dev.ml2sensors.capture.NativePixelSource
import dev.ml2sensors.capture.NativePoseSource
import dev.ml2sensors.capture.PixelSensor
import dev.ml2sensors.capture.PoseSensor
import dev.ml2sensors.simulator.signal.SignalSource
import dev.ml2sensors.simulator.testsignal.battery
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourcedHeadset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.filter
import java.nio.file.Path

/**
 * The headset's own code on a simulation of the vendor's library: cameras and poses come through libml2sensors.so, what
 * the platform would deliver comes from the same simulated room and walk. One per process.
 *
 * No stream delivers before the pictures of all cameras that are started together are drawn.
 */
internal class SimulatedHeadset private constructor(private val headset: Headset) : Headset by headset {
    private val opening = Opening(headset.clock, SimulatedSdk::isDrawing)

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> =
        headset.samples(stream, values).filter { opening.isOver() }

    companion object {
        /** Khronos', which finds the simulated runtime by XR_RUNTIME_JSON. */
        private const val OPENXR_LOADER = "libopenxr_loader.so.1"

        /**
         * @param library libml2sensors.so.
         * @param simulation libml2sim_jni.so.
         * @param seed of the room, the walk and all noise.
         * @param settings further ones of the simulation, in order.
         * @throws WrongSetting with the simulation's words.
         */
        fun open(library: Path, simulation: Path, seed: Long, settings: List<SimulatedSetting>): Headset {
            SimulatedSdk.load(simulation)
            (listOf(SimulatedSetting("seed", "$seed")) + settings).forEach(SimulatedSetting::apply)
            NativeLibrary.load(library)
            NativeLibrary.useOpenXr(OPENXR_LOADER, context = null)
            val identity = Headset.Identity("simulated-$seed", "Simulated headset, seed $seed")
            return SimulatedHeadset(SourcedHeadset(identity, NativeHeadsetClock, sources()))
        }
    }
}

/** As on the device, but for what Android would deliver. */
private fun sources(): List<SensorSource> =
    listOf(PixelSensor.WORLD, PixelSensor.DEPTH, PixelSensor.EYE).map { NativePixelSource(it, NativeBackend.SDK) } +
        NativePoseSource(PoseSensor.HEAD, NativeBackend.SDK) +
        PixelSensor.entries.map { NativePixelSource(it, NativeBackend.OPENXR) } +
        PoseSensor.entries.map { NativePoseSource(it, NativeBackend.OPENXR) } +
        SimulatedCamera2() +
        SignalSource("sensor_manager", NativeHeadsetClock, sensorManagerSignals()) +
        SignalSource("battery_manager", NativeHeadsetClock, mapOf(StreamTable.battery to battery()))
