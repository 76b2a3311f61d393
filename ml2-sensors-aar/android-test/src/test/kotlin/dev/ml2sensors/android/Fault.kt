package dev.ml2sensors.android

import android.hardware.camera2.CameraAccessException
import android.net.nsd.NsdManager
import dev.ml2sensors.android.HarshPlatform.Companion.ADDRESS
import dev.ml2sensors.android.HarshPlatform.Companion.CAMERA
import dev.ml2sensors.android.HarshPlatform.Companion.DESK
import dev.ml2sensors.android.HarshPlatform.Companion.SECOND
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.CountDownLatch
import kotlin.random.Random

/** A fault of the platform. [begin] draws its details, and returns what ends it, or null if it does not last. */
internal class Fault(val name: String, val begin: HarshHeadset.(Random) -> (() -> Unit)?) {
    companion object {
        /** All faults: of the network, the camera, the other sensors, and of what the user and the platform do. */
        val ALL: List<Fault> get() =
            NETWORK_FAULTS + CAMERA_FAULTS + SENSOR_FAULTS + LIFECYCLE_FAULTS + NeverReturns.CALLS.map(::neverReturning)

        private val CAMERA_CALLS_OF_CONTEXT = setOf("Context.getSystemService", "Context.checkSelfPermission")

        private fun neverReturning(call: String) = Fault("$call never returns") { random ->
            when (call.substringBefore('.').takeUnless { call in CAMERA_CALLS_OF_CONTEXT } ?: call) {
                "Context.checkSelfPermission" -> cameraNeverReturns(call)

                "Context.getSystemService" -> cameraNeverReturns(call).also {
                    some(platform.sensors.keys, random).forEach(::restart)
                }

                "SensorManager" -> NeverReturns.hold(call).also {
                    some(platform.sensors.keys, random).forEach(::restart)
                }

                "Context" -> NeverReturns.hold(call).also { restart(StreamTable.battery) }

                "BatteryManager", "PowerManager", "MulticastLock" -> NeverReturns.hold(call)

                "NsdManager" -> NeverReturns.hold(call).also {
                    if (call == "NsdManager.constructor") platform.renewBrowser()
                }

                "KeyStore" -> NeverReturns.hold(call).also {
                    if (call == "KeyStore.generateKeyPair") platform.keystore.forget()
                }

                "MediaCodec", "MediaCodecList" -> videoNeverReturns(call)

                "YuvImage" -> encodingNeverReturns(call)

                else -> cameraNeverReturns(call)
            }
        }
    }
}

/** The calls of the platform that do not return at present. */
internal object NeverReturns {
    /** The product's calls that need an answer of another process, a driver or the vendor's library. */
    val CALLS = listOf(
        "CameraManager.getCameraIdList", "CameraManager.getCameraCharacteristics", "CameraManager.openCamera",
        "CameraDevice.createCaptureSession", "CameraDevice.createCaptureRequest",
        "CameraCaptureSession.setRepeatingRequest", "CameraDevice.close", "ImageReader.newInstance",
        "ImageReader.acquireNextImage", "ColorPoses.open", "ColorPoses.close", "ColorPoses.capture", "ColorPoses.pose",
        "YuvImage.compressToJpeg", "MediaCodecList.constructor", "MediaCodec.createByCodecName",
        "MediaCodec.setCallback", "MediaCodec.configure", "MediaCodec.start", "MediaCodec.getInputBuffer",
        "MediaCodec.getInputImage", "MediaCodec.setParameters", "MediaCodec.queueInputBuffer",
        "MediaCodec.getOutputBuffer", "MediaCodec.releaseOutputBuffer", "MediaCodec.release", "NsdManager.constructor",
        "NsdManager.discoverServices", "NsdManager.stopServiceDiscovery", "NsdManager.resolveService",
        "MulticastLock.acquire", "MulticastLock.release", "SensorManager.getSensorList",
        "SensorManager.registerListener", "SensorManager.unregisterListener", "Context.getSystemService",
        "Context.registerReceiver", "Context.unregisterReceiver", "Context.checkSelfPermission",
        "BatteryManager.getLongProperty", "PowerManager.isInteractive", "PowerManager.getCurrentThermalStatus",
    ) + FakeKeystore.CALLS.map { "KeyStore.$it" }
    private val held = ConcurrentHashMap<String, CountDownLatch>()
    private val waiting = ConcurrentHashMap<Thread, CountDownLatch>()

    /** The threads of calls that the product has given up. */
    val givenUp: MutableSet<Thread> = ConcurrentHashMap.newKeySet()

    /** The [CALLS] that have blocked a thread so far. */
    val seen: MutableSet<String> = ConcurrentHashMap.newKeySet()

    /** Lets [call] not return; returns what ends that. */
    fun hold(call: String): () -> Unit {
        val answer = CountDownLatch(1)
        held[call] = answer
        return {
            held.remove(call, answer)
            answer.countDown()
        }
    }

    /** Stands where the platform carries out [call]. */
    fun pass(call: String) {
        val answer = held[call] ?: return
        seen += call
        waiting[Thread.currentThread()] = answer
        answer.await()
        waiting.remove(Thread.currentThread())
    }

    fun isHeld(call: String): Boolean = held.containsKey(call)

    /** True if [thread] does not return from a call. */
    fun keeps(thread: Thread): Boolean = waiting[thread]?.count == 1L

    /** True if a thread with this [name] does not return from a call. */
    fun keepsOne(name: String): Boolean = waiting.keys.any { it.name == name && keeps(it) }

    /** Answers all. */
    fun reset() {
        held.values.forEach(CountDownLatch::countDown)
        held.clear()
    }
}

private fun HarshHeadset.videoNeverReturns(call: String): () -> Unit {
    val end = NeverReturns.hold(call)
    when (call.substringAfter('.')) {
        "constructor", "createByCodecName", "setCallback", "configure", "start", "release" -> platform.video.close()

        // It is closed while it keeps an image
        "getOutputBuffer", "releaseOutputBuffer" -> return {
            platform.video.close()
            end()
        }
    }
    return end
}

private fun HarshHeadset.cameraNeverReturns(call: String): () -> Unit {
    if (call == "ColorPoses.capture" || call == "ColorPoses.pose") {
        val end = NeverReturns.hold(call)
        return platform.muteCamera(::deliverResult, end)
    }
    if (call == "ImageReader.acquireNextImage") return platform.muteCamera(::announceImage, NeverReturns.hold(call))
    if (call.endsWith("close")) {
        val end = NeverReturns.hold(call)
        return platform.muteCamera({ loseCamera(CameraRig.DISCONNECTED) }, end)
    }
    loseCamera(CameraRig.DISCONNECTED)
    val end = NeverReturns.hold(call)
    return platform.muteCamera({}, end)
}

/** Takes camera 1 away, since camera 0 makes no JPEGs itself. */
private fun HarshHeadset.encodingNeverReturns(call: String): () -> Unit {
    val list = platform.unlistCamera()
    loseCamera(CameraRig.DISCONNECTED)
    val excuse = platform.excuse(setOf(StreamTable.color))
    val end = NeverReturns.hold(call)
    return {
        end()
        list()
        excuse()
    }
}

private val NETWORK_FAULTS = listOf(
    Fault("searches fail") { random ->
        val code = listOf(NsdManager.FAILURE_INTERNAL_ERROR, NsdManager.FAILURE_MAX_LIMIT).random(random)
        platform.networks.forEach { it.refusal = code };
        { platform.networks.forEach { it.refusal = null } }
    },
    Fault("resolutions hang") {
        platform.networks.forEach { it.isSlow = true };
        {
            platform.networks.forEach {
                it.isSlow = false
                it.resolveAll()
            }
        }
    },
    Fault("resolutions fail") {
        platform.networks.forEach { it.unresolvable += DESK };
        { platform.networks.forEach { it.unresolvable -= DESK } }
    },
    Fault("the receiver is gone") {
        platform.isOnTheNetwork = false
        platform.networks.forEach { it.vanish(DESK) };
        {
            platform.isOnTheNetwork = true
            platform.networks.forEach { it.appear(DESK, ADDRESS.host, ADDRESS.port) }
        }
    },
    Fault("the link is down") {
        disconnect();
        { connect() }
    },
)

private val CAMERA_FAULTS = listOf(
    Fault("the camera is taken away") {
        loseCamera(CameraRig.DISCONNECTED)
        null
    },
    Fault("the camera fails") { random ->
        loseCamera(random.nextInt(1, 7))
        null
    },
    Fault("frames are odd") { random ->
        platform.oddFrames += List(random.nextInt(1, 20)) { HarshPlatform.Frame.entries.random(random) }
        null
    },
    Fault("images are bad") { random ->
        platform.oddFrames += List(random.nextInt(1, 40)) { HarshPlatform.Frame.BAD_IMAGE }
        null
    },
    Fault("the camera cannot be opened") { random ->
        val cause = listOf(
            CameraAccessException(CameraAccessException.CAMERA_IN_USE),
            SecurityException("by policy"),
            IllegalArgumentException("unknown camera"),
        ).random(random)
        platform.refuseCamera(cause).also { loseCamera(CameraRig.DISCONNECTED) }
    },
    Fault("openings fail") { random ->
        CameraRig.openError = (listOf(CameraRig.DISCONNECTED) + (1..6)).random(random)
        loseCamera(CameraRig.DISCONNECTED);
        { CameraRig.openError = null }
    },
    Fault("openings hang") {
        loseCamera(CameraRig.DISCONNECTED)
        platform.muteCamera({ CameraRig.holdsOpenings = true }, { platform.rig.answerOpenings() })
    },
    Fault("cameras do not say that they are closed") {
        val end = platform.muteCamera({ CameraRig.holdsClosings = true }, { platform.rig.answerClosings() })
        loseCamera(CameraRig.DISCONNECTED)
        end
    },
    Fault("sessions never answer") {
        loseCamera(CameraRig.DISCONNECTED)
        platform.muteCamera({ CameraRig.holdsSessions = true }, { platform.rig.answerSessions() })
    },
    Fault("sessions are refused") {
        CameraRig.refusesSessions = true
        loseCamera(CameraRig.DISCONNECTED);
        { CameraRig.refusesSessions = false }
    },
    Fault("requests fail") { random ->
        CameraRig.requestFailure = listOf(
            CameraAccessException(CameraAccessException.CAMERA_ERROR),
            IllegalStateException("the session was closed"),
        ).random(random)
        loseCamera(CameraRig.DISCONNECTED);
        { CameraRig.requestFailure = null }
    },
    Fault("the camera is silent") { platform.silence(setOf(StreamTable.color)) },
    Fault("camera 1 is not listed") {
        platform.unlistCamera().also { loseCamera(CameraRig.DISCONNECTED) }
    },
    Fault("the pose tracker fails") { random ->
        platform.poses.failing = listOf("open", "capture", "pose", "close").random(random);
        { platform.poses.failing = null }
    },
    Fault("the encoder fails") {
        val excuse = platform.excuse(setOf(StreamTable.color))
        platform.encoder.fails = true;
        {
            platform.encoder.fails = false
            excuse()
        }
    },
)

private val SENSOR_FAULTS = listOf(
    Fault("sensors are silent") { random -> platform.silence(some(platform.sensors.keys, random)) },
    Fault("sensors do not start") { random ->
        SensorHub.refuses = true
        val silence = platform.silence(some(platform.sensors.keys, random));
        {
            SensorHub.refuses = false
            silence()
        }
    },
    Fault("timestamps jump") { random ->
        val jumping = some(platform.sensors.keys, random).associateWith { JUMPS_NANOS.random(random) }
        val excuse = platform.excuse(jumping.keys)
        platform.jumpsNanos += jumping;
        {
            platform.jumpsNanos -= jumping.keys
            excuse()
        }
    },
    Fault("sensors are not listed") { random ->
        val gone = some(platform.sensors.keys, random)
        gone.forEach { platform.hub.unlist(platform.sensors.getValue(it)) }
        val silence = platform.silence(gone);
        {
            gone.forEach { platform.hub.list(platform.sensors.getValue(it)) }
            silence()
        }
    },
    Fault("battery broadcasts are missing") { platform.silence(setOf(StreamTable.battery)) },
    Fault("battery broadcasts are odd") { random ->
        platform.batteryOddity = random;
        { platform.batteryOddity = null }
    },
    Fault("the state of the battery is unknown") {
        platform.stickyBroadcasts.clear()
        restart(StreamTable.battery)
        platform.silence(setOf(StreamTable.battery))
    },
)

private val LIFECYCLE_FAULTS = listOf(
    Fault("the app is in the background") {
        pause()
        val mend = listOf(
            platform.refuseCamera(CameraAccessException(CameraAccessException.CAMERA_DISABLED)),
            platform.silence(platform.sensors.keys),
        );
        {
            mend.forEach { it() }
            resume()
        }
    },
    Fault("the headset is not worn") {
        platform.power.setIsInteractive(false)
        val silence = platform.silence(platform.sensors.keys + StreamTable.color);
        {
            platform.power.setIsInteractive(true)
            silence()
        }
    },
    Fault("the headset was suspended") { random ->
        platform.excuse(HarshPlatform.STREAMS)()
        platform.device.suspendedNanos += random.nextLong(100 * SECOND)
        null
    },
    Fault("the permission is revoked") {
        shadowOf(RuntimeEnvironment.getApplication()).denyPermissions(CAMERA)
        loseCamera(CameraRig.DISCONNECTED);
        { shadowOf(RuntimeEnvironment.getApplication()).grantPermissions(CAMERA) }
    },
    Fault("the receiver configures again") { random ->
        restart(HarshPlatform.STREAMS.random(random))
        null
    },
)

/** The errors of a sensor's clock. */
private val JUMPS_NANOS = listOf(-3_600, -2, -1, 1, 2, 3_600).map { it * SECOND }

private fun some(sensors: Set<StreamSpec>, random: Random) = sensors.shuffled(random).take(random.nextInt(1, 4))
