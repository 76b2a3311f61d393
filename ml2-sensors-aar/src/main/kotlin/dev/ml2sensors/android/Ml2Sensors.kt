package dev.ml2sensors.android

import android.annotation.SuppressLint
import android.content.Context
import android.content.pm.PackageManager
import android.hardware.SensorManager
import android.hardware.camera2.CameraManager
import android.os.Build
import android.provider.Settings
import dev.ml2sensors.capture.NativeColorPoses
import dev.ml2sensors.capture.NativeSource
import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.pairing.PairedReceiver
import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.ColorPoses
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.SensorSource
import dev.ml2sensors.source.SourcedHeadset
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
        val headset = SourcedHeadset(identityOf(app), clocks.boot, sources.map { PermittedSource(app, it) }) {
            permissionsOf(app)
        }
        return AndroidHeadset(headset, native.orEmpty(), bases.asStateFlow())
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
     * A streamer of [headset], not yet started, to the receiver that this headset is paired with when it connects: the
     * one that announces itself, else the last one where it was paired. While it is paired with none,
     * [Ml2Streamer.state] says so.
     */
    public fun connect(context: Context, headset: Headset): Ml2Streamer {
        val app = context.applicationContext
        val keys = AndroidKeys.of(app)
        return Ml2Streamer(headset, keys.receiver(nsdBrowser(app)), keys.security())
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
    headset: SourcedHeadset,
    private val native: List<NativeSource>,
    private val foundBases: StateFlow<Map<StreamSpec, ClockDomain>>,
) : Headset by headset {
    override val timestampBases: Map<String, ClockDomain> get() = foundBases.value.mapKeys { (stream, _) -> stream.id }

    /** Gives the cameras and trackers back to the device while the app is not in front; their flows deliver nothing. */
    public fun pause(): Unit = native.forEach(NativeSource::pause)

    /** Takes them again; flows fail where that fails. */
    public fun resume(): Unit = native.forEach(NativeSource::resume)
}
