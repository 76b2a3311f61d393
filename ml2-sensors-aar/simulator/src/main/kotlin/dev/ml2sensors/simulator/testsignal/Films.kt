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

/** The film of each camera, for the values it was last asked for. Used by any thread. */
internal class Films(private val scope: CoroutineScope, private val log: (String) -> Unit) {
    private class Entry(val values: StreamValues, val film: Deferred<Film>)

    private val entries = ConcurrentHashMap<String, Entry>()

    /** Begins to draw, unless that has been done. */
    fun of(stream: StreamSpec, values: StreamValues): Deferred<Film> {
        val entry = entries.compute(stream.id) { _, last ->
            if (last?.values == values) return@compute last
            last?.film?.cancel()
            Entry(values, scope.async(DRAWING) { draw(stream, values) })
        }
        return checkNotNull(entry).film
    }

    suspend fun awaitAll(): Unit = entries.values.map { it.film }.joinAll()

    private suspend fun draw(stream: StreamSpec, values: StreamValues): Film {
        val frames = max(checkNotNull(values.rateHz), MIN_FRAMES)
        val what = "$frames frames of $stream, ${values.width}x${values.height}"
        log("drawing $what")
        val (film, duration) = measureTimedValue { camera(stream.id, values).film(frames) }
        log("drew $what in ${duration.inWholeMilliseconds} ms")
        return film
    }

    private companion object {
        /** A loop lasts one second, or longer at low rates so that it moves. */
        const val MIN_FRAMES = 5

        /** Beside the threads that deliver samples, and few enough that unfinished images do not fill the memory. */
        val DRAWING = Dispatchers.IO.limitedParallelism(Runtime.getRuntime().availableProcessors().coerceAtMost(4))
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
