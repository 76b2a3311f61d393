package dev.ml2sensors.capture

import dev.ml2sensors.message.Transform
import dev.ml2sensors.message.inverse
import dev.ml2sensors.message.times
import dev.ml2sensors.source.Distortion
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.BeforeEach
import org.junit.jupiter.api.Test
import kotlin.math.abs
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class NativePixelSourceTest {
    @BeforeEach
    fun begin(): Unit = Simulation.begin()

    @AfterEach
    fun end(): Unit = Simulation.assertIsLeftAsFound()

    @Test
    fun oneFrame(): Unit = runBlocking {
        NativePixelSource(PixelSensor.WORLD, NativeBackend.SDK).use { source ->
            val t = System.nanoTime()
            source.samples(StreamTable.worldLeft, StreamTable.worldLeft.defaultValues()).first { println(it); (it as? ImageSample)?.let { println("${it.width} ${it.intrinsics} ${it.pose}") }; true }
            println((System.nanoTime() - t) / 1e6)
        }
    }
}
