package dev.ml2sensors.android

import android.content.Context
import android.hardware.camera2.CameraManager
import android.util.Size
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.answer
import dev.ml2sensors.source.isVideo
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.Job
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.update
import java.util.Locale
import java.util.concurrent.ConcurrentHashMap

/**
 * Captures the colour camera, alone or with what the headset shows (mixed reality), as JPEGs through Camera2, or raw for
 * video. The camera encodes the JPEGs if that delays no other frame; otherwise this library does.
 *
 * `color` is camera 1 or 0, as [StreamValues.cameraId] says, or the other one if that is not listed: both show the same
 * sensor. While camera 1 is open, the headset tracks no markers. When any app uses mixed reality, camera 0 is closed.
 * `mixed_reality` is camera 3. The vendor defines these ids.
 *
 * @param foundBases receives the clock behind the timestamps of each stream that has no vendor timestamps.
 */
internal class Camera2Source(
    private val context: Context,
    private val poses: ColorPoses,
    private val clocks: SystemClocks = SystemClocks(),
    private val foundBases: MutableStateFlow<Map<StreamSpec, ClockDomain>> = MutableStateFlow(emptyMap()),
    private val workers: EncoderThreads = EncoderThreads(),
    private val encoder: JpegEncoder = JpegEncoder.ANDROID,
    private val encoderSpeed: EncoderSpeed = EncoderSpeed(encoder),
    private val calls: PlatformCalls = PlatformCalls(),
) : SensorSource {
    private val access = SensorAccess()

    /** The latest run of each stream, which may have been left behind. */
    private val runs = ConcurrentHashMap<StreamSpec, ColorCapture>()

    override val backend: String get() = BACKEND

    override val streams: Set<StreamSpec> get() = CAMERAS.keys

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer =
        try {
            when (val known = stream.answer(requested)) {
                is Answer.Refused -> known
                else -> camera(stream, requested).let { it.answer(stream, requested).namingCamera(it.id, requested) }
            }
        } catch (e: SourceException) {
            Answer.Refused(e.message.orEmpty())
        }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
        access.use { ending -> capture(stream, values, ending, this) }
    }

    private suspend fun capture(
        stream: StreamSpec,
        values: StreamValues,
        ending: Job,
        collector: FlowCollector<Sample>,
    ) {
        val (camera, plan) = calls.call("Android's description of the camera of $stream") {
            camera(stream, values).let { it to it.plan(values) }
        }
        runs[stream]?.checkEnded()
        if (plan == null) throw SourceException(camera.lacks(values.size))
        val tags = VendorTags(if (stream == StreamTable.mixedReality) MIXED_REALITY_TAGS else COLOR_TAGS)
        val timestamps =
            if (camera.stampsBootTime) {
                { timestamp: Long -> timestamp.takeIf { it > 0 } }
            } else {
                TimestampConverter(clocks) { base -> foundBases.update { it + (stream to base) } }::captureNanos
            }
        val run =
            ColorCapture(stream, context, camera, plan, values.hz, encoder, workers, ending, clocks.boot) { tracker ->
                ExposureReader(plan.size.width, plan.size.height, tags, tracker, timestamps)
            }
        runs[stream] = run
        run.deliverTo(collector, poses)
    }

    override fun pause(): Unit = access.pause()

    override fun resume(): Unit = access.resume()

    /** Ends all flows. */
    override fun close(): Unit = access.close()

    private fun camera(stream: StreamSpec, values: StreamValues): ColorCamera =
        ofAndroid("Android cannot describe its cameras") {
            val cameraManager = context.getSystemService(CameraManager::class.java)
            val listed = cameraManager.cameraIdList
            val wanted = CAMERAS.getValue(stream).sortedBy { it != values.cameraId?.toString() }
            val id = wanted.firstOrNull { it in listed } ?: throw SourceException(
                "this headset lists no camera ${wanted.first()}; it lists: ${listed.joinToString()}",
            )
            ColorCamera(id, cameraManager.getCameraCharacteristics(id), encoderSpeed, workers.count)
        }

    private fun ColorCamera.answer(stream: StreamSpec, requested: StreamValues): Answer {
        val plan = plan(requested) ?: return Answer.Refused(lacks(requested.size))
        val rates = stream.ratesHz(requested).filter(::offers).sorted()
        val rateHz = rates.lastOrNull { it <= requested.hz && plan.sustains(it) } ?: rates.firstOrNull()
        val ability = String.format(
            Locale.ROOT,
            "camera %s makes %.1f images of %s per second at most, and exposes at %s Hz",
            id,
            plan.sustainedHz,
            plan.size,
            rates.joinToString(),
        )
        return when {
            rateHz == null -> Answer.Refused("camera $id exposes at none of the rates that are legal for ${plan.size}")
            rateHz == requested.hz && plan.sustains(rateHz) -> Answer.Applied(requested)
            else -> Answer.Adjusted(requested.copy(rateHz = rateHz), ability)
        }
    }

    private fun ColorCamera.plan(values: StreamValues) =
        if (values.isVideo) rawPlan(values.size) else plan(values.size, values.hz)

    /** Adds a reason if camera [id] is used because the requested one is not listed. */
    private fun Answer.namingCamera(id: String, requested: StreamValues): Answer {
        val asked = requested.cameraId ?: return this
        val values = acceptedValues ?: return this
        if (asked == id.toInt()) return this
        val other = "this headset lists no camera $asked; camera $id serves instead"
        val reasons = listOfNotNull(other, (this as? Answer.Adjusted)?.reason)
        return Answer.Adjusted(values.copy(cameraId = id.toInt()), reasons.joinToString("; "))
    }

    companion object {
        /** The camera ids of each stream, the default one first. */
        private val CAMERAS = mapOf(StreamTable.color to listOf("1", "0"), StreamTable.mixedReality to listOf("3"))

        /** Returns what refuses the streams of this source without libml2sensors.so, whose slots have the JPEGs. */
        fun absent(): UnavailableSource = UnavailableSource(BACKEND, CAMERAS.keys, "not available: libml2sensors.so")

        private const val BACKEND = "camera2"
        private const val COLOR_TAGS = "com.amd.control"
        private const val MIXED_REALITY_TAGS = "com.ml.control"
    }
}

private val StreamValues.size: Size
    get() = Size(requireNotNull(width) { "no resolution_width" }, requireNotNull(height) { "no resolution_height" })

private val StreamValues.hz: Int get() = requireNotNull(rateHz) { "no update_rate" }

/** Returns the rates that the table allows for the requested resolution. */
private fun StreamSpec.ratesHz(requested: StreamValues): List<Int> =
    modes.filter { it.stream == requested.stream && requested.width to requested.height in it.resolutions }
        .flatMap { it.rates }
