package dev.ml2sensors.android

import android.app.Application
import android.content.BroadcastReceiver
import android.content.ContentResolver
import android.content.Context
import android.content.ContextWrapper
import android.content.Intent
import android.content.IntentFilter
import android.content.pm.PackageManager
import android.graphics.ImageFormat
import android.hardware.SensorManager
import android.hardware.camera2.CameraManager
import android.media.MediaCodecList
import android.os.BatteryManager
import android.os.PowerManager
import android.util.Size
import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.VideoEncoder
import dev.ml2sensors.source.VideoEncoders
import dev.ml2sensors.source.VideoOutput
import dev.ml2sensors.source.VideoPacket
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.MutableStateFlow
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import org.robolectric.shadow.api.Shadow
import org.robolectric.shadows.ShadowBatteryManager
import org.robolectric.shadows.ShadowMediaCodecList
import org.robolectric.shadows.ShadowPowerManager
import org.robolectric.util.ReflectionHelpers
import java.io.IOException
import java.nio.ByteBuffer
import java.nio.channels.GatheringByteChannel
import java.security.Security
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CopyOnWriteArrayList
import java.util.concurrent.Future
import java.util.concurrent.TimeoutException
import java.util.concurrent.atomic.AtomicInteger
import java.util.concurrent.atomic.AtomicLong
import kotlin.random.Random
import kotlin.time.Duration
import kotlin.time.Duration.Companion.milliseconds

/** Android and the devices below it: delivers to the product's sources when asked, and fails as told. */
internal class HarshPlatform(private val app: Application) {
    private val cameraManager = app.getSystemService(CameraManager::class.java)
    private val sensorManager = app.getSystemService(SensorManager::class.java)
    private val battery = shadowOf(app.getSystemService(BatteryManager::class.java))
    val power = shadowOf(app.getSystemService(PowerManager::class.java))
    val device = SettableClocks(monotonicNanos = 500 * SECOND, suspendedNanos = 7_000 * SECOND)
    val rig = CameraRig(cameraManager).apply {
        add("1", CAMERA_1)
        add("0", listOf(Mode(ImageFormat.YUV_420_888, VGA, minNanos = 33_333_333)))
    }
    val poses = FakePoses().apply { isThere = true }
    val encoder = FakeEncoder()
    private val ofSensors = HarshCalls()
    private val ofCamera = HarshCalls()
    private val ofBattery = HarshCalls()
    private val ofPower = HarshCalls()
    val ofQuestions = HarshCalls()
    private val ofPermissions = HarshCalls()
    val video = HarshVideo()

    /** True for each part of the platform of which no call is under way but those that never return. */
    val idleCalls: Map<String, Boolean>
        get() = mapOf(
            "sensors" to ofSensors,
            "the camera" to ofCamera,
            "the battery" to ofBattery,
            "power" to ofPower,
            "questions" to ofQuestions,
            "permissions" to ofPermissions,
            "video" to video.calls,
            "images of video" to video.callsOfImages,
            "the network" to ofNetwork,
        ).mapValues { (_, calls) -> calls.isIdle }
    val hub = SensorHub(sensorManager)
    val sensors = SensorRow.ALL.distinctBy { it.stream }.associate { it.stream to hub.add(it.type, it.name) }
    private val ofNetwork = HarshCalls()
    val networks = CopyOnWriteArrayList<FakeNsdManager>()
    var browser = nsdBrowser(app, ofNetwork)
        private set
    val keystore = FakeKeystore()

    /** True if the Keystore has returned the app's key when it was last asked. */
    var hasKey = false
        private set

    private val silent = mutableMapOf<StreamSpec, Int>()
    private val excuses = mutableMapOf<StreamSpec, Int>()
    private val recovering = STREAMS.toMutableSet()
    private val context = HarshContext(app)
    private val refusals = mutableListOf<Exception>()
    val jumpsNanos = mutableMapOf<StreamSpec, Long>()
    val oddFrames = ArrayDeque<Frame>()

    /** Draws the values of odd battery broadcasts; null while they are as they should be. */
    var batteryOddity: Random? = null
    var isOnTheNetwork = true

    private val picture = Picture(VGA.width, VGA.height, Random(1)).planes(Random(2)).map { it as FakePlane }
    private val images = mutableListOf<FakeImage>()

    val stickyBroadcasts: MutableMap<String?, Intent> get() = context.stickyBroadcasts

    /**
     * A bad frame: the camera delivers this in place of a good one.
     *
     * @property isAnswered false if the product cannot know that nothing more comes of it.
     */
    enum class Frame(val isAnswered: Boolean = true) {
        BAD_IMAGE,
        TOO_LARGE,
        FAILED,
        FAILED_AFTER_IMAGE(isAnswered = false),
        BUFFER_LOST,
        NO_RESULT(isAnswered = false),
    }

    /** True while the camera, its service or the vendor's tracker does not answer. */
    val isCameraMute: Boolean get() = mutes > 0
    private var mutes = 0
    private var unlistings = 0

    /** True while the encoder does not return the images that it was given. */
    val keepsImages: Boolean get() = NeverReturns.isHeld("YuvImage.compressToJpeg")

    init {
        FakeNsdManager.onConstructed = ::join
        keystore.before = { NeverReturns.pass("KeyStore.$it") }
        Security.addProvider(keystore)
    }

    /** Lets the camera not answer, in the way that [begin] begins; returns what ends that by [end]. */
    fun muteCamera(begin: () -> Unit, end: () -> Unit): () -> Unit {
        mutes++
        val excuse = excuse(setOf(StreamTable.color))
        begin()
        return {
            end()
            mutes--
            excuse()
        }
    }

    /** Lets the runs of [specs] end, until the returned function was called and they are published again. */
    fun excuse(specs: Collection<StreamSpec>): () -> Unit {
        recovering += specs
        specs.forEach { excuses.merge(it, 1, Int::plus) }
        return { specs.forEach { excuses.merge(it, -1, Int::plus) } }
    }

    fun isExcused(spec: StreamSpec): Boolean = spec in recovering

    /** [spec] is published. */
    fun recovered(spec: StreamSpec) {
        if (excuses.getOrDefault(spec, 0) == 0) recovering -= spec
    }

    /** Opens the product's sources, as an app does. */
    fun openHeadset(): AndroidHeadset = openHeadset(device.clocks, videoEncoders = null) { it }

    /** As [openHeadset], but with the limits of the product and the clock of this machine. */
    fun openInRealTime(): AndroidHeadset {
        AvcCodec.reset()
        AvcCodec.install(VGA.width, VGA.height)
        val clocks = SystemClocks(boot = System::nanoTime, monotonic = System::nanoTime)
        return openHeadset(clocks, MediaCodecEncoders()) { PlatformCalls() }
    }

    private fun openHeadset(
        clocks: SystemClocks,
        videoEncoders: VideoEncoders?,
        calls: (HarshCalls) -> PlatformCalls,
    ): AndroidHeadset {
        NativeSlots.load()
        shadowOf(app).grantPermissions(CAMERA)
        val bases = MutableStateFlow<Map<StreamSpec, ClockDomain>>(emptyMap())
        val sources = listOf(
            SensorManagerSource(context, clocks, bases, calls(ofSensors)),
            Camera2Source(context, poses, clocks, bases, EncoderThreads(2), encoder, calls = calls(ofCamera)),
            BatterySource(context, clocks.boot, calls(ofBattery)),
        ).map { PermissionCheckedSource(context, it, calls(ofPermissions)) }
        val headset = SensorHeadset(Headset.Identity("harsh", "harsh"), clocks.boot, sources, videoEncoders) {
            mapOf(CAMERA to (context.checkSelfPermission(CAMERA) == PackageManager.PERMISSION_GRANTED))
        }
        return AndroidHeadset(context, headset, clocks, bases, calls(ofPower))
    }

    /** Lets every sensor measure now, by the clock of this machine. */
    fun measureInRealTime() {
        sensors.values.forEach { hub.measure(it, System.nanoTime(), 1f, 2f, 3f, 4f, 5f, 6f) }
        broadcast()
    }

    /** Asks for the app's key unless there is one, as a session does; only briefly while the Keystore does not answer. */
    fun askForKey() {
        val isHeld = FakeKeystore.CALLS.any { NeverReturns.isHeld("KeyStore.$it") }
        if (hasKey && !isHeld) return
        hasKey = try {
            AndroidKeys.of(app, if (isHeld) 1.milliseconds else TEST_LIMIT).identity
            check(keystore.aliases.size == 1) { "the Keystore has the keys ${keystore.aliases}" }
            true
        } catch (e: IOException) {
            check(isHeld) { "the Keystore answers, but there is no key: $e" }
            false
        }
    }

    /** Searches with an NsdManager that is not made yet, as another start of an app does. */
    fun renewBrowser() {
        networks.removeIf { !it.isSearching }
        browser = nsdBrowser(app, ofNetwork)
    }

    fun isSilent(spec: StreamSpec): Boolean = silent.getOrDefault(spec, 0) > 0

    /** Lets the sensors of [specs] measure nothing; returns what ends that. */
    fun silence(specs: Collection<StreamSpec>): () -> Unit {
        specs.forEach { silent.merge(it, 1, Int::plus) }
        val excuse = excuse(specs)
        return {
            specs.forEach { silent.merge(it, -1, Int::plus) }
            excuse()
        }
    }

    /** Lists camera 1, which makes JPEGs itself, no longer; returns what ends that. */
    fun unlistCamera(): () -> Unit {
        if (unlistings++ == 0) rig.remove("1")
        return { if (--unlistings == 0) rig.add("1", CAMERA_1) }
    }

    /** Lets no camera open; returns what ends that. */
    fun refuseCamera(cause: Exception): () -> Unit {
        refusals += cause
        CameraRig.failure = cause
        val excuse = excuse(setOf(StreamTable.color))
        return {
            excuse()
            refusals -= cause
            CameraRig.failure = refusals.lastOrNull()
        }
    }

    /** Lets a sensor measure, if its time is wrong often enough to be given up; [afterEach] gets its listeners. */
    fun measure(spec: StreamSpec, afterEach: (Int) -> Unit) {
        val jump = jumpsNanos[spec]
        repeat(if (jump == null) 1 else BURST) {
            val stamp = device.bootNanos - SECOND / 10 + it + (jump ?: 0)
            afterEach(hub.measure(sensors.getValue(spec), stamp, 1f, 2f, 3f, 4f, 5f, 6f))
        }
    }

    /** The number of battery states that were delivered with a registration. */
    val deliveredAtOnce: Long get() = context.deliveredAtOnce.getAndSet(0)

    /** Broadcasts the state of the battery; returns the number of receivers that are read. */
    fun broadcast(): Int {
        val oddity = batteryOddity
        val intent = Intent(Intent.ACTION_BATTERY_CHANGED)
        for ((name, value) in BATTERY) {
            when (oddity?.nextInt(4) ?: 0) {
                0 -> intent.putExtra(name, value)
                1 -> intent.putExtra(name, ODD_NUMBERS.random(checkNotNull(oddity)))
                2 -> intent.putExtra(name, "not a number")
            }
        }
        val current = if (oddity == null) -1_600_000 else listOf(Long.MIN_VALUE, 0, Long.MAX_VALUE).random(oddity)
        battery.setLongProperty(BatteryManager.BATTERY_PROPERTY_CURRENT_NOW, current)
        stickyBroadcasts[intent.action] = intent
        val receivers = shadowOf(app).registeredReceivers.filter { it.intentFilter.hasAction(intent.action) }
        receivers.forEach { it.broadcastReceiver.onReceive(app, intent) }
        return receivers.count { it.broadcastReceiver !in context.left }
    }

    /** Delivers one frame, an [odd] one if that is not null. Returns false if the camera was closed before. */
    fun deliver(running: CameraRig.Running, odd: Frame?, stamp: Long): Boolean = with(rig) {
        when (odd) {
            Frame.FAILED -> running.fail(wasImageCaptured = false)

            Frame.FAILED_AFTER_IMAGE -> {
                running.fail(wasImageCaptured = true)
                running.deliverImage(null, stamp)
            }

            Frame.NO_RESULT -> running.deliverImage(null, stamp)

            Frame.BUFFER_LOST -> {
                running.result(stamp, tags = tags(stamp))
                running.loseBuffer()
            }

            else -> {
                running.result(stamp, exposureNanos = SECOND / 100, tags = tags(stamp))
                running.deliverImage(odd, stamp)
            }
        }
    }

    /** As [deliver], but of a result alone, which the camera's thread gets when it has time. */
    fun postResult(running: CameraRig.Running, stamp: Long) = running.handler.post {
        with(rig) { running.resultHere(stamp, exposureNanos = SECOND / 100, tags = tags(stamp)) }
    }

    private fun CameraRig.Running.deliverImage(odd: Frame?, stamp: Long): Boolean {
        val format = CameraRig.readers.singleOrNull()?.reader?.imageFormat ?: return false
        val image = when {
            odd == Frame.BAD_IMAGE -> FakeImage(format, VGA.width, VGA.height, stamp, emptyList())
            format == ImageFormat.YUV_420_888 -> FakeImage(format, VGA.width, VGA.height, stamp, picture)
            else -> FakeImage.jpeg(stamp, if (odd == Frame.TOO_LARGE) LARGE_JPEG else SMALL_JPEG)
        }
        return with(rig) { image(image) }.also { isDelivered -> if (isDelivered) images += image }
    }

    /** The vendor's tags, with the exposure around [monotonicNanos]. */
    private fun tags(monotonicNanos: Long): Map<String, Any> {
        val centre = monotonicNanos + device.suspendedNanos - FakePoses.ML_TIME_IN_BOOT_TIME
        return mapOf(
            "com.amd.control.cvip_timestamps" to longArrayOf(0, centre, 0, 0),
            "com.amd.control.intrinsics" to
                floatArrayOf(1280f, 960f, 901f, 902f, 641f, 481f, 70f, .1f, .2f, .3f, .4f, .5f),
        )
    }

    /** Checks that the product has closed every image. */
    fun checkImages() {
        check(images.all { it.isClosed }) { "an image was not closed" }
        images.clear()
    }

    private fun join(network: FakeNsdManager) {
        networks.firstOrNull()?.let { first ->
            network.refusal = first.refusal
            network.isSlow = first.isSlow
            network.unresolvable += first.unresolvable
        }
        network.appear("robot", "fd00::7", 7756)
        if (isOnTheNetwork) network.appear(DESK, ADDRESS.host, ADDRESS.port)
        networks += network
    }

    /** Returns where the threads of the product and of coroutines stand. */
    fun threadDump(): String = Thread.getAllStackTraces()
        .filterKeys { it.name.startsWith("ml2s") || it.name.startsWith("DefaultDispatcher") }
        .map { (thread, stack) -> "${thread.name}, ${thread.state}:\n  ${stack.joinToString("\n  ")}" }
        .joinToString("\n")

    /** Returns the number of things that are open, by name. */
    fun open(): Map<String, Int> = mapOf(
        "cameras" to rig.countOpen(),
        "image readers" to CameraRig.readers.size,
        "pose trackers" to poses.open,
        "sensors" to hub.enabled.size,
        "sensor queues" to hub.queueCount,
        "broadcast receivers" to shadowOf(app).registeredReceivers.size,
        "searches" to networks.count { it.isSearching },
        "multicast locks" to FakeMulticastLock.held.get(),
    )

    companion object {
        const val SECOND = 1_000_000_000L
        const val CAMERA = "android.permission.CAMERA"
        const val DESK = "desk"
        val ADDRESS = ReceiverAddress("192.168.1.5", 7755)
        private val VGA = Size(640, 480)
        private val CAMERA_1 =
            listOf(ImageFormat.JPEG, ImageFormat.YUV_420_888).map { Mode(it, VGA, minNanos = 33_333_333) }

        /** All streams that Android's classes deliver but mixed reality, whose camera is of the same class. */
        val STREAMS: Set<StreamSpec> = SensorRow.ALL.map { it.stream }.toSet() + StreamTable.color + StreamTable.battery
        private val SMALL_JPEG = byteArrayOf(1, 2, 3)
        private val LARGE_JPEG = ByteArray(VGA.width * VGA.height + 1)
        private val ODD_NUMBERS = listOf(0, -1, 1, Int.MAX_VALUE, Int.MIN_VALUE)
        private val BATTERY = mapOf(
            BatteryManager.EXTRA_LEVEL to 80,
            BatteryManager.EXTRA_SCALE to 100,
            BatteryManager.EXTRA_STATUS to BatteryManager.BATTERY_STATUS_DISCHARGING,
            BatteryManager.EXTRA_VOLTAGE to 7_700,
            BatteryManager.EXTRA_TEMPERATURE to 310,
        )

        /** More than half of the readings after which a clock is unknown for good. */
        private const val BURST = 60
    }
}

/** A context of Android whose services, settings and registrations may not return. */
internal class HarshContext(private val app: Application) : ContextWrapper(app) {
    /** The receivers that the product no longer reads. */
    val left: MutableSet<BroadcastReceiver> = ConcurrentHashMap.newKeySet()
    val deliveredAtOnce = AtomicLong()

    /** The latest intents of Robolectric, which cannot remove one and prints each that it broadcasts. */
    val stickyBroadcasts: MutableMap<String?, Intent> by lazy {
        val instrumentation =
            ReflectionHelpers.callInstanceMethod<Any>(RuntimeEnvironment.getActivityThread(), "getInstrumentation")
        ReflectionHelpers.getField(Shadow.extract(instrumentation), "stickyIntents")
    }

    override fun getApplicationContext(): Context = this

    override fun getSystemService(name: String): Any? {
        NeverReturns.pass("Context.getSystemService")
        return super.getSystemService(name)
    }

    override fun checkSelfPermission(permission: String): Int {
        NeverReturns.pass("Context.checkSelfPermission")
        return super.checkSelfPermission(permission)
    }

    override fun getContentResolver(): ContentResolver {
        NeverReturns.pass("Settings.Secure")
        return super.getContentResolver()
    }

    override fun registerReceiver(receiver: BroadcastReceiver?, filter: IntentFilter): Intent? {
        NeverReturns.pass("Context.registerReceiver")
        if (Thread.currentThread() in NeverReturns.givenUp) {
            left += checkNotNull(receiver)
        } else {
            deliveredAtOnce.addAndGet(stickyBroadcasts.size.toLong())
        }
        return super.registerReceiver(receiver, filter)
    }

    override fun unregisterReceiver(receiver: BroadcastReceiver) {
        left += receiver
        NeverReturns.pass("Context.unregisterReceiver")
        super.unregisterReceiver(receiver)
        left -= receiver
    }

    companion object {
        /** The calls that opening a headset makes. */
        val CALLS_OF_OPENING = listOf("Context.getSystemService", "Settings.Secure")
    }
}

/** Android's BatteryManager, PowerManager and MediaCodecList, which may not return. */
@Implements(BatteryManager::class)
internal class HarshBattery : ShadowBatteryManager() {
    @Implementation
    public override fun getLongProperty(id: Int): Long {
        NeverReturns.pass("BatteryManager.getLongProperty")
        return super.getLongProperty(id)
    }
}

@Implements(PowerManager::class)
internal class HarshPower : ShadowPowerManager() {
    @Implementation
    public override fun getCurrentThermalStatus(): Int {
        NeverReturns.pass("PowerManager.getCurrentThermalStatus")
        return super.getCurrentThermalStatus()
    }

    @Implementation
    public override fun isInteractive(): Boolean {
        NeverReturns.pass("PowerManager.isInteractive")
        return super.isInteractive()
    }
}

@Implements(MediaCodecList::class)
internal class HarshCodecList : ShadowMediaCodecList() {
    companion object {
        @JvmStatic
        @Implementation
        fun initCodecList() {
            NeverReturns.pass("MediaCodecList.constructor")
            Shadow.directlyOn<Unit, MediaCodecList>(MediaCodecList::class.java, "initCodecList")
        }
    }
}

/** Calls of the product that give up as soon as the platform is known not to return: no limit passes in virtual time. */
internal class HarshCalls : PlatformCalls() {
    private val begun = AtomicInteger()
    private val threads = ConcurrentHashMap<Runnable, Thread>()

    val isIdle: Boolean get() = threads.size == begun.get() && threads.values.all(::isStuck)

    override fun execute(call: Runnable) {
        begun.incrementAndGet()
        super.execute {
            threads[call] = Thread.currentThread()
            call.run()
            NeverReturns.givenUp -= Thread.currentThread()
            threads -= call
            begun.decrementAndGet()
        }
    }

    override fun <T> await(call: Future<T>, patience: Duration): T {
        while (!call.isDone) {
            val thread = threads[call as Runnable]
            if (thread != null && isStuck(thread)) {
                NeverReturns.givenUp += thread
                throw TimeoutException()
            }
            Thread.yield()
        }
        return call.get()
    }

    /** A call may also wait for one that never returns: for its lock, or for the thread of the encoder. */
    private fun isStuck(thread: Thread) = NeverReturns.keeps(thread) ||
        (thread.state == Thread.State.BLOCKED && threads.values.any(NeverReturns::keeps)) ||
        (thread.state == Thread.State.WAITING && NeverReturns.keepsOne("ml2s-video"))
}

/** A video beside the streams, whose encoder is opened again when it has failed. */
internal class HarshVideo : VideoOutput {
    val calls = HarshCalls()

    /** Stands for the thread of the stream, which nobody waits for without a limit. */
    val callsOfImages = HarshCalls()
    private val encoders = MediaCodecEncoders(calls)
    private var encoder: VideoEncoder? = null
    private var micros = 0L
    private var isKeyFrame = false

    @Volatile
    var packets = 0
        private set

    init {
        AvcCodec.install(MediaCodecEncodersTest.WIDTH, MediaCodecEncodersTest.HEIGHT)
    }

    override fun packet(packet: VideoPacket) {
        packets++
    }

    override fun failed(cause: Exception) = throw cause

    fun tick() {
        AvcCodec.inputs.clear()
        val open = encoder ?: try {
            encoders.open(MediaCodecEncodersTest.SETTINGS, this)
        } catch (_: NoAnswerException) {
            return
        }
        encoder = open
        micros += 250_000
        isKeyFrame = !isKeyFrame
        try {
            callsOfImages.call("the video's image") { open.encode(PICTURE, micros, isKeyFrame) }
        } catch (_: NoAnswerException) {
            // It goes on with this encoder, or with the next one, when that returns
        }
    }

    fun close() {
        encoder?.close()
        encoder = null
    }

    private companion object {
        val PICTURE = MediaCodecEncodersTest.picture(0)
    }
}

/** A link that takes everything. */
internal object Nowhere : GatheringByteChannel {
    override fun write(source: ByteBuffer): Int = source.remaining().also { source.position(source.limit()) }

    override fun write(sources: Array<out ByteBuffer>): Long = sources.sumOf { write(it).toLong() }

    override fun write(sources: Array<out ByteBuffer>, offset: Int, length: Int): Long =
        sources.slice(offset until offset + length).sumOf { write(it).toLong() }

    override fun isOpen() = true

    override fun close() = Unit
}
