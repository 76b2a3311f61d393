package dev.ml2sensors.android

import android.hardware.camera2.CameraAccessException
import android.net.nsd.NsdManager
import dev.ml2sensors.android.HarshPlatform.Companion.ADDRESS
import dev.ml2sensors.android.HarshPlatform.Companion.CAMERA
import dev.ml2sensors.android.HarshPlatform.Companion.DESK
import dev.ml2sensors.android.HarshPlatform.Companion.JPEG
import dev.ml2sensors.android.HarshPlatform.Companion.SECOND
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import java.util.concurrent.CountDownLatch
import kotlin.random.Random

/** A fault of the platform. [begin] draws its details, and returns what ends it, or null if it does not last. */
internal class Fault(val name: String, val begin: HarshHeadset.(Random) -> (() -> Unit)?) {
    companion object {
        /** All faults: of the network, the camera, the other sensors, and of what the user and the platform do. */
        val ALL: List<Fault> get() = NETWORK_FAULTS + CAMERA_FAULTS + SENSOR_FAULTS + LIFECYCLE_FAULTS
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
    Fault("calls to open cameras do not return") {
        loseCamera(CameraRig.DISCONNECTED)
        val answer = CountDownLatch(1)
        platform.muteCamera({ CameraRig.opening = answer }, {
            CameraRig.opening = null
            answer.countDown()
        })
    },
    Fault("cameras do not say that they are closed") {
        val end = platform.muteCamera({ CameraRig.holdsClosings = true }, { platform.rig.answerClosings() })
        loseCamera(CameraRig.DISCONNECTED)
        end
    },
    Fault("calls to close cameras do not return") {
        val answer = CountDownLatch(1)
        val end = platform.muteCamera({ CameraRig.closing = answer }, {
            CameraRig.closing = null
            answer.countDown()
        })
        loseCamera(CameraRig.DISCONNECTED)
        end
    },
    Fault("sessions never answer") {
        loseCamera(CameraRig.DISCONNECTED)
        platform.muteCamera({ CameraRig.holdsSessions = true }, { platform.rig.answerSessions() })
    },
    Fault("the pose tracker does not return") { random ->
        val answer = CountDownLatch(1)
        val call = listOf("open", "close").random(random)
        val end = platform.muteCamera({ platform.poses.hanging = call to answer }, {
            platform.poses.hanging = null
            answer.countDown()
        })
        loseCamera(CameraRig.DISCONNECTED)
        end
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
        platform.rig.remove("1")
        loseCamera(CameraRig.DISCONNECTED);
        { platform.rig.add("1", listOf(JPEG)) }
    },
    Fault("the pose tracker fails") { random ->
        platform.poses.failing = listOf("open", "capture", "pose", "close").random(random);
        { platform.poses.failing = null }
    },
    Fault("the encoder fails") {
        platform.encoder.fails = true;
        { platform.encoder.fails = false }
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
    Fault("calls to start sensors do not return") { random ->
        val answer = CountDownLatch(1)
        SensorHub.hanging = answer
        val silence = platform.silence(platform.sensors.keys)
        some(platform.sensors.keys, random).forEach(::restart);
        {
            SensorHub.hanging = null
            answer.countDown()
            awaitLateAnswers()
            silence()
        }
    },
    Fault("timestamps jump") { random ->
        val jumping = some(platform.sensors.keys, random).associateWith { JUMPS_NANOS.random(random) }
        platform.jumpsNanos += jumping;
        { platform.jumpsNanos -= jumping.keys }
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
