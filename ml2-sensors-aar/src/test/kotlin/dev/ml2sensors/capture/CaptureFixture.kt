package dev.ml2sensors.capture

import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.filterIsInstance
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.firstOrNull
import kotlinx.coroutines.flow.map
import kotlinx.coroutines.flow.take
import kotlinx.coroutines.launch
import java.util.concurrent.ConcurrentHashMap
import kotlin.test.assertEquals

/** The native sources of one test on a simulated device of its own. */
internal class CaptureFixture : AutoCloseable {
    val world = NativePixelSource(PixelSensor.WORLD, NativeBackend.SDK)
    val depth = NativePixelSource(PixelSensor.DEPTH, NativeBackend.SDK)
    val eyes = NativePixelSource(PixelSensor.EYE, NativeBackend.SDK)
    private val trackers = NativeReadingSource.all(NativeBackend.SDK)
    private val sources = listOf(world, depth, eyes) + trackers
    private val collected = mutableSetOf<StreamSpec>()

    init {
        Simulation.begin()
    }

    fun samples(stream: StreamSpec, values: StreamValues = values(stream)): Flow<Sample> {
        collected += stream
        return sources.first { stream in it.streams }.samples(stream, values)
    }

    /** Emits the result of [read] for each image while it is lent. */
    fun <T> images(stream: StreamSpec, values: StreamValues = values(stream), read: (ImageSample) -> T): Flow<T> =
        samples(stream, values).filterIsInstance<ImageSample>().map { read(it) }

    suspend fun <T> image(stream: StreamSpec, values: StreamValues = values(stream), read: (ImageSample) -> T): T =
        images(stream, values, read).first()

    /** Nothing is held of the device or of the slots any more, and the device was never misused. */
    override fun close() {
        sources.forEach(NativeSource::close)
        Simulation.assertIsLeftAsFound()
        for (stream in collected - trackers.flatMap { it.streams }.toSet()) {
            val leased = (0 until SlotPool.SLOTS).filter { slot ->
                runCatching { SlotPool.release(stream, slot) }.isSuccess
            }
            assertEquals(emptyList(), leased, "slots of $stream that nobody gave back")
        }
        assertEquals(0, Native.mappedBytes(), "memory of streams that have ended")
    }

    companion object {
        fun values(stream: StreamSpec): StreamValues =
            if (stream == StreamTable.depth || stream == StreamTable.infra) SHORT_RANGE else stream.defaultValues()

        val SHORT_RANGE = StreamValues(stream = 1, width = 544, height = 480, rateHz = 30, format = "Depth32")
    }
}

/** Collects two flows at once, until a number has come of both; returns null if 600 of [other] have none of [one]. */
internal suspend fun inCommon(one: Flow<Long>, other: Flow<Long>): Long? = coroutineScope {
    val ofOne = ConcurrentHashMap.newKeySet<Long>()
    val ofOther = mutableSetOf<Long>()
    val collector = launch(Dispatchers.Default) { one.collect { ofOne += it } }
    other.take(600).firstOrNull { ofOther.add(it) && ofOther.any(ofOne::contains) }.also { collector.cancelAndJoin() }
}
