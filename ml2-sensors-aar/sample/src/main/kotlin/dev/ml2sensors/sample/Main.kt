package dev.ml2sensors.sample

import dev.ml2sensors.capture.NativeLibrary
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.PoseSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.mapNotNull
import kotlinx.coroutines.runBlocking
import java.nio.ByteBuffer
import java.nio.file.Path

/**
 * Prints a description of the first frame of each stream that the vendor's SDK serves by its pixel sensors and its head
 * tracker. The argument is the path of libml2sensors.so; in an app, `NativeLibrary.load()` finds it in the package.
 */
fun main(arguments: Array<String>) {
    NativeLibrary.load(Path.of(arguments.single()))
    NativeLibrary.openHeadset(Headset.Identity("sample", "Sample")).use { headset ->
        for (stream in StreamTable.all) println("${stream.id}: ${firstFrame(headset, stream)}")
    }
}

private fun firstFrame(headset: Headset, stream: StreamSpec): String =
    when (val answer = headset.negotiate(stream, stream.defaultValues())) {
        is Answer.Applied -> first(headset.samples(stream, answer.values))
        is Answer.Adjusted -> first(headset.samples(stream, answer.values))
        is Answer.Refused -> "refused, ${answer.reason}"
    }

/** Describes samples inside the flow, since the memory of an image is only valid there. */
private fun first(samples: Flow<Sample>): String = runBlocking { samples.mapNotNull(::describe).first() }

private fun describe(sample: Sample): String? =
    when (sample) {
        is ImageSample -> "${sample.width} x ${sample.height}, mean byte ${mean(sample.pixels)}"
        is PoseSample -> sample.pose?.let { "at ${it.translation}" }
        else -> null
    }

private fun mean(bytes: ByteBuffer): Long {
    val count = bytes.remaining()
    var sum = 0L
    while (bytes.hasRemaining()) sum += bytes.get().toInt() and 0xff
    return sum / count
}
