package dev.ml2sensors.capture

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.LostSamples
import dev.ml2sensors.source.SourceException
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.runBlocking
import java.nio.file.Path

/** A program of its own: says of the first stream of each sensor what is answered, and whether a sample comes. */
internal object Probe {
    @JvmStatic
    fun main(args: Array<String>) {
        NativeLibrary.load(Path.of("../build/native/device/libml2sensors.so"))
        val cameras = listOf(PixelSensor.DEPTH, PixelSensor.WORLD, PixelSensor.EYE)
        val sources = cameras.map { NativePixelSource(it, NativeBackend.SDK) } +
            listOf(ReadingSensor.HEAD, ReadingSensor.CONTROLLER_INPUT).map {
                NativeReadingSource(it, NativeBackend.SDK)
            }
        sources.forEach { source -> source.use(::probe) }
        NativeReadingSource(ReadingSensor.GAZE, NativeBackend.OPENXR).use(::probe)
        NativeLibrary.useOpenXr("libno-such-loader.so", context = null)
        NativeReadingSource(ReadingSensor.GAZE, NativeBackend.OPENXR).use(::probe)
    }

    private fun probe(source: NativeSource) = runBlocking {
        val stream = source.streams.first()
        val values = CaptureFixture.values(stream)
        val answer = when (val it = source.negotiate(stream, values)) {
            is Answer.Refused -> it.reason
            else -> "accepted"
        }
        val end = try {
            source.samples(stream, values).first { it !is LostSamples }.javaClass.simpleName
        } catch (e: SourceException) {
            e.toString().substringAfterLast('$')
        }
        println("$stream: $answer; $end")
    }
}
