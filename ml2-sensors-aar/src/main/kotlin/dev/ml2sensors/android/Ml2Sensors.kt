package dev.ml2sensors.android

import android.annotation.SuppressLint
import android.content.Context
import android.content.pm.PackageManager
import android.os.Build
import android.os.PowerManager
import android.provider.Settings
import android.util.Log
import dev.ml2sensors.capture.NativeColorPoses
import dev.ml2sensors.pairing.DeviceKeys
import dev.ml2sensors.pairing.PairedReceiver
import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.source.ClockDomain
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
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
    private val calls = PlatformCalls()

    /**
     * Opens every sensor of the headset. No stream starts. A missing library, sensor or permission refuses only the
     * streams that need it. Close the result when it is no longer needed.
     *
     * OpenXR is used only after a call of [dev.ml2sensors.capture.NativeLibrary.useOpenXr].
     */
    public fun open(context: Context): AndroidHeadset {
        val app = context.applicationContext
        val bases = MutableStateFlow<Map<StreamSpec, ClockDomain>>(emptyMap())
        val clocks = SystemClocks()
        val native = loadNativeSources(clocks::suspendedNanos)
        val sources = listOf(
            SensorManagerSource(app, clocks, bases),
            native?.let { Camera2Source(app, NativeColorPoses, clocks, bases) } ?: Camera2Source.absent(),
            BatterySource(app, clocks.boot),
        ) + (native ?: absentNativeSources())
        val checked = sources.map { PermissionCheckedSource(app, it, calls) }
        val headset =
            SensorHeadset(identityOf(app), clocks.boot, checked, MediaCodecEncoders()) { permissionsOf(app) }
        return AndroidHeadset(app, headset, clocks, bases.asStateFlow())
    }

    /**
     * Pairs this headset with the receiver that shows [uri], the text or QR code of `ml2-receiver pair`. Needed once;
     * then [connect] finds the receiver. If Android's Keystore cannot read the key of this app any more, a new one is
     * made, and the log says so: receivers that were paired before need another pairing.
     *
     * @throws IllegalArgumentException if [uri] is not a pairing URI; surrounding spaces are ignored.
     * @throws dev.ml2sensors.pairing.PairingException when the receiver refuses or does not answer.
     * @throws dev.ml2sensors.transport.TransportException when another machine answers, or without TLS 1.3.
     * @throws java.io.IOException when Android's Keystore fails, or the receiver cannot be stored.
     */
    public suspend fun pair(context: Context, uri: String): PairedReceiver = pair(context, uri) {}

    /** As the public one; [keyReplaced] also receives why a new key was made, if one was made in place of another. */
    internal suspend fun pair(context: Context, uri: String, keyReplaced: (reason: String) -> Unit): PairedReceiver {
        val app = context.applicationContext
        val keys = AndroidKeys.forPairing(app) { reason ->
            val said = "$reason; pairing made a new one, and receivers that were paired before need another pairing"
            Log.w("ml2s", said)
            keyReplaced(said)
        }
        return keys.pair(PairingUri.parse(uri.trim()), identityOf(app))
    }

    /**
     * Returns the receivers that this headset is paired with, the latest one last. Do not call it on the main thread.
     *
     * @throws java.io.IOException when the list of receivers cannot be read.
     */
    public fun receivers(context: Context): List<PairedReceiver> = AndroidKeys.of(context.applicationContext).receivers

    /**
     * Returns a streamer of [headset], not yet started, to a paired receiver. Without [receiver] it connects to the
     * paired receiver that announces itself, or else to the last known address of the latest one. While this headset is
     * not paired, [Ml2Streamer.state] says so.
     *
     * @param receiver a name or `HOST:PORT`, as [Receiver.parse] takes it.
     * @throws IllegalArgumentException if [receiver] is neither.
     */
    public fun connect(context: Context, headset: Headset, receiver: String = ""): Ml2Streamer {
        val app = context.applicationContext
        val keys = AndroidKeys.of(app)
        val browser = nsdBrowser(app)
        val wanted = if (receiver.isEmpty()) keys.receiver(browser) else Receiver.parse(receiver, browser)
        return Ml2Streamer(headset, wanted, keys.security())
    }

    /** Derives the device id from Android's id for this app, user and device; the hash reveals neither. */
    private fun identityOf(context: Context): Headset.Identity {
        val androidId = androidId(context).orEmpty()
        val hash = MessageDigest.getInstance("SHA-256").digest("${context.packageName} $androidId".toByteArray())
        return Headset.Identity(hash.take(ID_BYTES).joinToString("") { "%02x".format(it) }, Build.MODEL)
    }

    /** Returns null if Android has no such id, or does not answer. */
    @SuppressLint("HardwareIds")
    private fun androidId(context: Context): String? = try {
        calls.call("Android's id of this device") {
            Settings.Secure.getString(context.contentResolver, Settings.Secure.ANDROID_ID)
        }
    } catch (e: NoAnswerException) {
        Log.w("ml2s", "the device id is one that other headsets may have, too: ${e.message}")
        null
    }

    private fun permissionsOf(context: Context): Map<String, Boolean> =
        StreamTable.all.flatMap { it.permissions }.distinct()
            .associateWith { context.checkSelfPermission(it) == PackageManager.PERMISSION_GRANTED }

    private const val ID_BYTES = 16
}

/** An opened headset. Its [Headset.clock] is CLOCK_BOOTTIME. */
public class AndroidHeadset internal constructor(
    private val context: Context,
    private val headset: SensorHeadset,
    private val clocks: SystemClocks,
    private val foundBases: StateFlow<Map<StreamSpec, ClockDomain>>,
    private val calls: PlatformCalls = PlatformCalls(),
) : Headset by headset {
    override val timestampBases: Map<String, ClockDomain> get() = foundBases.value.mapKeys { (stream, _) -> stream.id }

    override val suspendedNanos: Long get() = clocks.suspendedNanos()

    /** No permissions while Android does not answer. */
    override val permissions: Map<String, Boolean> get() = ask("permissions") { headset.permissions }.orEmpty()

    /** A headset that nobody wears falls asleep. */
    override val sleepReason: String?
        get() = if (askPower { it.isInteractive } == false) "the headset is not worn, or asleep" else null

    /** [Thermal] has the order of Android's numbers. */
    override val thermal: Thermal? get() = askPower { it.currentThermalStatus }?.let(Thermal.entries::getOrNull)

    private fun <T> askPower(question: (PowerManager) -> T): T? =
        ask("PowerManager") { question(context.getSystemService(PowerManager::class.java)) }

    /** Returns the answer of Android's [part], or null if it does not answer. */
    private fun <T> ask(part: String, question: () -> T): T? = try {
        calls.call("Android's $part", action = question)
    } catch (_: NoAnswerException) {
        null
    }

    /** Releases all sensors while the app is in the background; their flows deliver nothing, and [holds] says why. */
    public fun pause(): Unit = headset.pause()

    /** Opens the sensors again; a flow whose sensor cannot be opened fails. */
    public fun resume(): Unit = headset.resume()
}
