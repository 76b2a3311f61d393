// The example in the README of the simulator. tests/aar compares both texts, compiles this file and runs it.

package dev.ml2sensors.sample

import dev.ml2sensors.simulator.SimulatedHeadset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.runBlocking

fun main(): Unit = runBlocking {
    SimulatedHeadset.open(seed = 7, settings = mapOf("loop_seconds" to "2")).use { headset ->
        val stream = StreamTable.worldLeft
        headset.samples(stream, stream.defaultValues()).filterIsInstance<ImageSample>().take(3).collect { image ->
            println("${image.width}x${image.height} at ${image.captureNanos}, pose ${image.pose}")
        }
        headset.set("fault.world.stalled", "1") // from now on no world camera delivers anything
    }
}
