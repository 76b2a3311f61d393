package dev.ml2sensors.android

import android.app.Application
import android.os.Looper
import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.StampMap
import dev.ml2sensors.pacing.AdaptedStream
import dev.ml2sensors.pacing.ImageSetting
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.DerivedStreamsHeadset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.SourceException
import dev.ml2sensors.source.acceptedValues
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.stream.CameraPipeline
import dev.ml2sensors.stream.FrameIds
import dev.ml2sensors.stream.MeasurementPipeline
import dev.ml2sensors.stream.StreamStates
import dev.ml2sensors.stream.StreamSupervisor
import dev.ml2sensors.stream.TopicChannels
import dev.ml2sensors.stream.TrackingEvents
import dev.ml2sensors.stream.TransformTree
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.FrameWriter
import dev.ml2sensors.wire.Status
import kotlinx.coroutines.Job
import kotlinx.coroutines.currentCoroutineContext
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.job
import kotlinx.coroutines.launch
import kotlinx.coroutines.test.TestScope
import org.robolectric.Shadows.shadowOf
import java.io.IOException
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/**
 * The product's Android sources on a [HarshPlatform], supervised and published as in an app. Time is virtual: it passes
 * only in [tick], in which every working sensor measures and the invariants are checked. The threads of the product
 * are awaited without sleeping.
 */
internal class HarshHeadset(app: Application, private val scope: TestScope) {
    private val scheduler = scope.testScheduler
    val platform = HarshPlatform(app)
    val headset = platform.openHeadset()
    private val stamps = StampMap(platform.device.clocks.boot).apply {
        steerTo(offsetNanos = HarshPlatform.SECOND, platform.device.bootNanos)
    }
    private val states = StreamStates(headset)
    private val topics = TopicChannels(suspendsWhenFull = false)
    private val tree = TransformTree(stamps, isLive = true, TrackingEvents {}) {}
    private val streams = HarshPlatform.STREAMS.associateWith(::Stream)
    private val color = streams.getValue(StreamTable.color)
    private val lanes = streams.values.flatMap { it.channels }.map { it.lane }.distinct()
    private var links = emptyList<Job>()
    private var run: Run? = null

    /** The run whose images the encoder has kept, until they are counted or the run is over. */
    private var keptOf: Run? = null
    private var isPaused = false

    /** True if a frame of this tick has ended a run. */
    private var hasRunEnded = false
    private var search: Job? = null
    private var located: ReceiverAddress? = null
    private val wrong = mutableListOf<String>()

    /** As a session asks what a stream can do. */
    private val asked = DerivedStreamsHeadset(headset, platform.ofQuestions)

    /** One collection of the camera's flow. */
    private class Run(val job: Job) {
        var camera: CameraRig.Running? = null

        @Volatile
        var isOver = false

        /** True from a pause to the next camera. Until the encoder returns its images, or the run is left, none comes. */
        var isPausing = false

        override fun toString() = "a run whose job is $job and whose camera ${camera?.let { "is there" } ?: "is not"}"
    }

    /** A stream, and how much of it the platform has delivered. */
    private inner class Stream(val spec: StreamSpec) {
        val values = checkNotNull(headset.negotiate(spec, spec.defaultValues()).acceptedValues) { "$spec is refused" }
        val channels = topics.of(spec, values)
        lateinit var job: Job
        var delivered = 0L
        var published = 0L
        var counted = 0L
        var countedAt = scheduler.timeSource.markNow()

        val state: Status.Stream get() = states.toBodies { _, state -> state }.getValue(spec.id)
        val counts: List<Status.ChannelCounts> get() = channels.map { it.counters.snapshot() }
        val produced: Long get() = counts.first().produced

        /** The number of samples that were not dropped. */
        val sent: Long get() = counts.first().run { produced - dropped.values.sum() }

        fun start() {
            countedAt = scheduler.timeSource.markNow()
            val supervisor = StreamSupervisor(
                spec.longestPauseSeconds?.seconds,
                isHeld = { spec.id in headset.holds },
                sleepReason = { headset.sleepReason },
                scheduler.timeSource,
            ) { states.setStopped(spec.id, it) }
            job = scope.backgroundScope.launch {
                supervisor.run({ opened() }) { samples ->
                    if (spec == StreamTable.color) {
                        val images = AdaptedStream(spec.id, ImageSetting(checkNotNull(values.rateHz), quality = null))
                        CameraPipeline(spec, channels, stamps, tree, FrameIds(), images).run(samples)
                    } else {
                        MeasurementPipeline(spec, values, channels.single(), stamps, FrameIds()).run(samples)
                    }
                }
            }
        }

        private fun opened(): Flow<Sample> = flow {
            val samples = headset.samples(spec, values)
            try {
                emitAll(if (spec == StreamTable.color) observed(samples) else samples.onEach(::checkPercentage))
                throw SourceException("its samples have ended")
            } catch (e: Throwable) {
                platform.sensors[spec]?.let(platform.hub::leave)
                if (!platform.isExcused(spec)) wrong += "$spec has ended, though nothing is wrong with it: $e"
                throw e
            }
        }

        private fun observed(samples: Flow<Sample>) = flow {
            val own = Run(currentCoroutineContext().job)
            while (platform.rig.nextRunning() != null) Unit
            run = own
            try {
                emitAll(samples)
            } finally {
                own.isOver = true
            }
        }

        private fun checkPercentage(sample: Sample) {
            val percentage = (sample as? BatterySample)?.percentage ?: return
            if (!percentage.isNaN() && percentage !in 0f..1f) wrong += "the battery is charged by $percentage"
        }
    }

    /** Starts all streams. */
    fun start() {
        states.setAnswers(streams.keys.associate { it.id to headset.negotiate(it, it.defaultValues()) }, emptySet())
        connect()
        streams.values.forEach { it.start() }
    }

    /** Lets time pass, lets everything measure, and checks what holds at any time. */
    fun tick() {
        hasRunEnded = false
        scheduler.advanceTimeBy(TICK)
        platform.device.monotonicNanos += TICK.inWholeNanoseconds
        settle()
        takeKeptImages()
        for (stream in streams.values) if (!platform.isSilent(stream.spec)) measure(stream)
        platform.video.tick()
        platform.askForKey()
        headset.thermal
        headset.permissions
        if (search?.isActive != true) search = scope.backgroundScope.launch { search() }
        settle()
        streams.getValue(StreamTable.battery).delivered += platform.deliveredAtOnce
        takeKeptImages()
        streams.values.forEach(::checkHonest)
        streams.values.forEach(::checkCounters)
        platform.checkImages()
        check(wrong.isEmpty()) { wrong }
    }

    private fun measure(stream: Stream) = when (stream.spec) {
        StreamTable.battery -> stream.delivered += platform.broadcast()

        StreamTable.color -> frames()

        else -> platform.measure(stream.spec) { listeners ->
            stream.delivered += listeners
            scheduler.runCurrent()
        }
    }

    private fun frames() {
        // Else its thread may be blocked, too
        if (platform.isCameraMute || (keptOf != null && !platform.keepsImages)) return
        val current = run?.takeIf { !it.isOver && it.job.isActive } ?: return
        val camera = current.camera ?: return
        // That an image has no result is known when the next result arrives
        val frames = platform.oddFrames.flatMap { if (it.isAnswered) listOf(it) else listOf(it, null) } + null
        if (frames.size > 1) platform.excuse(setOf(StreamTable.color))()
        platform.oddFrames.clear()
        var stamp = platform.device.monotonicNanos - HarshPlatform.SECOND / 5
        for (frame in frames) {
            stamp += HarshPlatform.SECOND / 1_000
            if (!platform.deliver(camera, frame, stamp)) break
            color.delivered++
            if (frame?.isAnswered != false && !platform.keepsImages) awaitCounted()
        }
        if (platform.keepsImages) {
            keptOf = current
            return
        }
        awaitCounted()
        if (!camera.isClosed) return
        hasRunEnded = true
        // A session that answers after a pause is of a camera that was closed; the run goes on with the next one
        await("the run is over, or has another camera") {
            // An event after the end of a run belongs to the next run
            if (!current.isOver) current.camera = platform.rig.nextRunning() ?: camera
            current.isOver || current.camera != camera
        }
    }

    /** Lets the camera tell of a capture, without waiting for its thread. That there is no image is no loss yet. */
    fun deliverResult() {
        val camera = run?.takeIf { !it.isOver }?.camera ?: return
        platform.postResult(camera, platform.device.monotonicNanos - HarshPlatform.SECOND / 5)
    }

    /** Lets the camera tell of an image that is gone when it is looked for, without waiting for its thread. */
    fun announceImage() {
        run?.takeIf { !it.isOver }?.camera?.postAnnouncement()
    }

    /** Counts on the images that the encoder has kept, but for those of a run that was given up. */
    private fun takeKeptImages() {
        val keeper = keptOf ?: return
        if (platform.keepsImages || (!keeper.isOver && color.produced != color.delivered)) return
        color.delivered = color.produced
        color.published = color.sent
        keptOf = null
    }

    private fun awaitCounted() = await("the frames are counted") { color.produced == color.delivered }

    private suspend fun search() {
        located = try {
            Receiver.discover(platform.browser, HarshPlatform.DESK).locate()
        } catch (_: IOException) {
            null
        }
    }

    fun connect() {
        links = lanes.map { scope.backgroundScope.launch { it.sendThrough(FrameWriter(Nowhere) { 0 }) } }
    }

    fun disconnect() {
        links.forEach(Job::cancel)
        await("the lanes are down") { links.all { it.isCompleted } }
    }

    /** Lets the camera fail with [error] if it runs, and returns when it is closed, unless it does not answer. */
    fun loseCamera(error: Int) {
        // Before its end; one that is about to be opened may fail, too
        platform.excuse(setOf(StreamTable.color))()
        val current = run?.takeIf { !it.isOver && it.camera != null } ?: return
        if (error == CameraRig.DISCONNECTED) CameraRig.opened.disconnect() else CameraRig.opened.fail(error)
        if (!isCameraStuck) await("the camera is closed") { current.isOver }
    }

    /** Pauses the headset, and returns when its camera is closed, unless it does not answer. */
    fun pause() {
        platform.excuse(streams.keys)()
        headset.pause()
        isPaused = true
        if (!platform.isCameraMute) await("the camera is closed") { platform.rig.countOpen() == 0 }
        run?.let {
            it.camera = null
            it.isPausing = true
        }
    }

    fun resume() {
        while (platform.rig.nextRunning() != null) Unit
        isPaused = false
        headset.resume()
        // The battery is told at once, and the next fault may pause it again
        val battery = streams.getValue(StreamTable.battery)
        await("the battery is registered") { platform.idleCalls.values.all { it } }
        battery.delivered += platform.deliveredAtOnce
        checkHonest(battery)
    }

    /** Ends and starts a stream, as a new configuration does. */
    fun restart(spec: StreamSpec) {
        val stream = streams.getValue(spec)
        platform.excuse(setOf(spec))()
        asked.negotiate(spec, stream.values)
        stream.job.cancel()
        if (spec == StreamTable.color && isCameraStuck) repeat(TICKS_TO_STOP) { tick() }
        await("$spec stops") { stream.job.isCompleted }
        states.setStopped(spec.id, null)
        stream.start()
    }

    /** Waits until the threads of the product have done what there is to do at this time. */
    private fun settle() = awaitAll {
        listOf(
            "the camera has opened or closed" to isCameraSettled(),
            "the lanes are empty" to streams.values.all { stream -> stream.counts.all(::areBalanced) },
        ) + platform.idleCalls.map { (of, isIdle) -> "the calls of $of have returned" to isIdle }
    }

    /** True while a run of the camera may not end. */
    private val isCameraStuck get() = platform.isCameraMute || platform.keepsImages || keptOf != null

    private fun isCameraSettled(): Boolean {
        val current = run ?: return true
        val isGivenUp = isCameraStuck && !current.job.isActive
        if (current.isOver || isPaused || platform.isCameraMute || isGivenUp) return true
        if (current.camera == null) current.camera = platform.rig.nextRunning()
        if (current.camera != null) current.isPausing = false
        return (current.camera != null && current.job.isActive) || (isCameraStuck && current.isPausing)
    }

    private fun await(what: String, isSo: () -> Boolean) = awaitAll { listOf(what to isSo()) }

    /** Waits until all [conditions] are met, which have names. */
    private fun awaitAll(conditions: () -> List<Pair<String, Boolean>>) {
        val start = TimeSource.Monotonic.markNow()
        while (true) {
            scheduler.runCurrent()
            shadowOf(Looper.getMainLooper()).idle()
            val unmet = conditions().filterNot { (_, isMet) -> isMet }
            if (unmet.isEmpty()) return
            check(start.elapsedNow() < PATIENCE) {
                "not within $PATIENCE: ${unmet.map { it.first }}, $run\n${platform.threadDump()}"
            }
            Thread.yield()
        }
    }

    /** Checks that a stream whose counters stand still says why, and that a published one says that it runs. */
    private fun checkHonest(stream: Stream) {
        val state = stream.state
        val published = stream.sent
        val hasStopped = stream == color && (hasRunEnded || keptOf != null)
        check(published == stream.published || hasStopped || state.state == Status.Stream.RUNNING) {
            "${stream.spec} is published, but ${state.reason}"
        }
        if (published > stream.published) platform.recovered(stream.spec)
        stream.published = published
        if (stream.produced != stream.counted || stream.spec.id in headset.holds) {
            stream.counted = stream.produced
            stream.countedAt = scheduler.timeSource.markNow()
        }
        val most = (stream.spec.longestPauseSeconds ?: return).seconds + OPENING + TICK * 2
        val silence = stream.countedAt.elapsedNow()
        check(silence <= most || (state.state == Status.Stream.WAITING && !state.reason.isNullOrEmpty())) {
            "${stream.spec} has been silent for $silence and is '${state.state}': ${state.reason}"
        }
    }

    /** Checks that what the platform delivered is produced, and that what is produced is sent or counted as lost. */
    private fun checkCounters(stream: Stream) {
        val isKept = stream == color && keptOf != null
        for (counts in stream.counts) {
            check(isKept || (areBalanced(counts) && counts.produced == stream.delivered)) {
                "of ${stream.spec}, ${stream.delivered} were delivered, ${counts.produced} produced, " +
                    "${counts.sent} sent and dropped ${counts.dropped}"
            }
        }
    }

    private fun areBalanced(counts: Status.ChannelCounts) = counts.produced == counts.sent + counts.dropped.values.sum()

    /** Ticks until every stream is published, the receiver is found and the pose tracker is open. */
    fun recover() {
        val start = scheduler.timeSource.markNow()
        val before = streams.mapValues { (_, it) -> it.published }
        val packets = platform.video.packets
        located = null
        while (true) {
            tick()
            val dead = streams.filter { (spec, it) ->
                it.published == before[spec] || it.state.state != Status.Stream.RUNNING
            }
            val isEncoded = platform.video.packets > packets
            val isAnswered = located == HarshPlatform.ADDRESS && platform.poses.open == 1 && platform.hasKey
            if (dead.isEmpty() && isEncoded && isAnswered) return
            check(start.elapsedNow() < RECOVERY) {
                val reasons = dead.map { (spec, it) -> "$spec is ${it.state.state}: ${it.state.reason}" }
                "not back after $RECOVERY: $reasons, found $located, ${platform.poses.open} pose trackers, " +
                    "${platform.video.packets - packets} images of video, a key: ${platform.hasKey}"
            }
        }
    }

    /** Returns the number of things that are open, by name. */
    fun open(): Map<String, Int> {
        search?.cancel()
        settle()
        await("the threads of closed cameras end") { threads("ml2s-camera") == CameraRig.readers.size }
        return platform.open() + ("threads" to threads("ml2s-"))
    }

    private fun threads(name: String) = Thread.getAllStackTraces().keys.count { it.name.startsWith(name) }

    /** Stops all streams and closes the headset. */
    fun close() {
        platform.excuse(streams.keys)
        streams.values.forEach { it.job.cancel() }
        await("all streams end") { streams.values.all { it.job.isCompleted } }
        disconnect()
        headset.close()
        platform.video.close()
        await("all threads end") { threads("ml2s-") == 0 }
        check(NativeSlots.mappedBytes == 0L) { "${NativeSlots.mappedBytes} bytes of images are leased in the end" }
    }

    private companion object {
        val TICK = 250.milliseconds

        /** The longest time that a source may take to open before its stream says why it is silent. */
        val OPENING = 6.seconds

        /** Three seconds, within which a stream stops though its camera does not answer. */
        const val TICKS_TO_STOP = 12

        /** The longest wait for threads of the product, in real time. */
        val PATIENCE = TEST_LIMIT

        /** More than the longest pauses of the supervisor and of the pose tracker after a silence. */
        val RECOVERY = 40.seconds
    }
}
