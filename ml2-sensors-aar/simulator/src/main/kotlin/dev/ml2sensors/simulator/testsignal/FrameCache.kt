package dev.ml2sensors.simulator.testsignal

import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.joinAll
import java.util.concurrent.ConcurrentHashMap
import kotlin.math.max
import kotlin.time.measureTimedValue

/** Keeps the rendered frames of each camera, for the values that were last requested. Thread-safe. */
internal class FrameCache(private val scope: CoroutineScope, private val log: (String) -> Unit) {
    private class Entry(val values: StreamValues, val loop: Deferred<FrameLoop>)

    private val entries = ConcurrentHashMap<String, Entry>()

    /** Returns the frames of a camera. Starts to render them if that was not done for these values. */
    fun of(stream: StreamSpec, values: StreamValues): Deferred<FrameLoop> {
        val entry = entries.compute(stream.id) { _, last ->
            if (last?.values == values) return@compute last
            last?.loop?.cancel()
            Entry(values, scope.async(RENDERING) { draw(stream, values) })
        }
        return checkNotNull(entry).loop
    }

    suspend fun awaitAll(): Unit = entries.values.map { it.loop }.joinAll()

    private suspend fun draw(stream: StreamSpec, values: StreamValues): FrameLoop {
        val frames = max(checkNotNull(values.rateHz), MIN_FRAMES)
        val what = "$frames frames of $stream, ${values.width}x${values.height}"
        log("rendering $what")
        val (loop, duration) = measureTimedValue { camera(stream.id, values).renderLoop(frames) }
        log("rendered $what in ${duration.inWholeMilliseconds} ms")
        return loop
    }

    private companion object {
        /** A loop lasts one second, or longer at low rates, so that it shows motion. */
        const val MIN_FRAMES = 5

        /** Apart from the threads that deliver samples. Few threads, so that unfinished images do not fill the memory. */
        val RENDERING = Dispatchers.IO.limitedParallelism(Runtime.getRuntime().availableProcessors().coerceAtMost(4))
    }
}

private fun camera(stream: String, values: StreamValues): Camera = when (stream) {
    "world_center", "world_left", "world_right" -> worldCamera(stream, isLowExposure = values.stream == 1)
    "color" -> colorCamera(stream, checkNotNull(values.width), checkNotNull(values.height), isMixed = false)
    "mixed_reality" -> colorCamera(stream, checkNotNull(values.width), checkNotNull(values.height), isMixed = true)
    "depth" -> depthCamera(values)
    "infra" -> infraredCamera(values)
    else -> eyeCamera(stream)
}
