package dev.ml2sensors.android

import android.annotation.SuppressLint
import android.content.Context
import android.content.pm.PackageManager
import android.hardware.SensorManager
import android.hardware.camera2.CameraManager
import android.os.Build
import android.os.PowerManager
import android.provider.Settings
import dev.ml2sensors.capture.NativeColorPoses
import dev.ml2sensors.capture.NativeSource
import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.pairing.PairedReceiver
import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.SensorHeadset
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.Thermal
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.flow.MutableStateFlow
import kotlinx.coroutines.flow.StateFlow
import kotlinx.coroutines.flow.asStateFlow
import java.security.MessageDigest

/** The headset that this app runs on. */
public object Ml2Sensors {
    /**
     * Every sensor of the headset. Nothing is started, and what is missing (a library, a sensor, a permission) only
     * refuses the streams that need it. To be closed when no longer needed.
     *
     * OpenXR is reached as [dev.ml2sensors.capture.NativeLibrary.useOpenXr] was told, and not at all without.
     */
    public fun open(context: Context): AndroidHeadset {
        val app = context.applicationContext
        val native = loadNativeSources()
        val bases = MutableStateFlow<Map<StreamSpec, ClockDomain>>(emptyMap())
        val clocks = SystemClocks()
        val poses = if (native == null) ColorPoses { null } else NativeColorPoses
        val sources = listOf(
            SensorManagerSource(app.getSystemService(SensorManager::class.java), clocks, bases),
            Camera2Source(app.getSystemService(CameraManager::class.java), poses, clocks, bases),
            BatterySource(app, clocks.boot),
        ) + (native ?: absentNativeSources())
        val headset = SensorHeadset(identityOf(app), clocks.boot, sources.map { PermissionCheckedSource(app, it) }) {
            permissionsOf(app)
        }
        val power = app.getSystemService(PowerManager::class.java)
        return AndroidHeadset(headset, native.orEmpty(), bases.asStateFlow(), power)
    }

    /**
     * Pairs this headset with the receiver that shows [uri], text or QR code of `ml2-receiver pair`: once, then
     * [connect] finds it.
     *
     * @throws IllegalArgumentException for a text that is no such URI, spaces around it aside.
     * @throws java.io.IOException as [DeviceKeys.pair] does.
     */
    public suspend fun pair(context: Context, uri: String): PairedReceiver {
        val app = context.applicationContext
        return AndroidKeys.of(app).pair(PairingUri.parse(uri.trim()), identityOf(app))
    }

    /**
     * The receivers that this headset is paired with, the last one last. Not on the main thread.
     *
     * @throws java.io.IOException when what is known of them cannot be read.
     */
    public fun receivers(context: Context): List<PairedReceiver> = AndroidKeys.of(context.applicationContext).receivers

    /**
     * A streamer of [headset], not yet started, to a receiver that this headset is paired with: without [receiver] the
     * one that announces itself, else the last one where it was paired. While it is paired with none,
     * [Ml2Streamer.state] says so.
     *
     * @param receiver a name or `HOST:PORT`, as [Receiver.parse] takes it.
     * @throws IllegalArgumentException for a [receiver] that is neither.
     */
    public fun connect(context: Context, headset: Headset, receiver: String = ""): Ml2Streamer {
        val app = context.applicationContext
        val keys = AndroidKeys.of(app)
        val browser = nsdBrowser(app)
        val wanted = if (receiver.isEmpty()) keys.receiver(browser) else Receiver.parse(receiver, browser)
        return Ml2Streamer(headset, wanted, keys.security())
    }

    /** The id is Android's for this app, user and device, and tells nothing else of any of them. */
    @SuppressLint("HardwareIds")
    private fun identityOf(context: Context): Headset.Identity {
        val androidId = Settings.Secure.getString(context.contentResolver, Settings.Secure.ANDROID_ID).orEmpty()
        val hash = MessageDigest.getInstance("SHA-256").digest("${context.packageName} $androidId".toByteArray())
        return Headset.Identity(hash.take(ID_BYTES).joinToString("") { "%02x".format(it) }, Build.MODEL)
    }

    private fun permissionsOf(context: Context): Map<String, Boolean> =
        StreamTable.all.flatMap { it.permissions }.distinct()
            .associateWith { context.checkSelfPermission(it) == PackageManager.PERMISSION_GRANTED }

    private const val ID_BYTES = 16
}

/**
 * An opened headset; [Headset.clock] is CLOCK_BOOTTIME.
 */
public class AndroidHeadset internal constructor(
    headset: SensorHeadset,
    private val native: List<NativeSource>,
    private val foundBases: StateFlow<Map<StreamSpec, ClockDomain>>,
    private val power: PowerManager,
) : Headset by headset {
    override val timestampBases: Map<String, ClockDomain> get() = foundBases.value.mapKeys { (stream, _) -> stream.id }

    /** Android's numbers are the order of [Thermal]. */
    override val thermal: Thermal? get() = Thermal.entries.getOrNull(power.currentThermalStatus)

    /** Gives the cameras and trackers back to the device while the app is not in front; their flows deliver nothing. */
    public fun pause(): Unit = native.forEach(NativeSource::pause)

    /** Takes them again; flows fail where that fails. */
    public fun resume(): Unit = native.forEach(NativeSource::resume)
}
