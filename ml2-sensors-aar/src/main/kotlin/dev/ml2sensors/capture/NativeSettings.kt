package dev.ml2sensors.capture

import java.nio.ByteBuffer

/** ml2s_settings; streams are ML2S_STREAM_BITs, 0 stands for what a sensor does not have. */
internal data class NativeSettings(
    val sensor: Int,
    val backend: Int,
    val streams: Long,
    val secondStreams: Long = 0,
    val wants: Int = 0,
    val rateHz: Int = 0,
    val width: Int = 0,
    val height: Int = 0,
    val markers: MarkerSettings = MarkerSettings(),
    val map: MapSettings = MapSettings(),
) {
    /** Opens the sensor and returns its handle, which belongs to this thread. */
    fun open(): Long = Native.open(toStruct())

    /** Gives these settings to the open sensor [handle]. */
    fun configure(handle: Long): Unit = Native.configure(handle, toStruct())

    private fun toStruct(): ByteBuffer = structMemory(1, SettingsLayout.sizeBytes).apply {
        putInt(SettingsLayout.sensor, sensor)
        putInt(SettingsLayout.backend, backend)
        putInt(SettingsLayout.wants, wants)
        putLong(SettingsLayout.streams, streams)
        putLong(SettingsLayout.secondStreams, secondStreams)
        putInt(SettingsLayout.rateHz, rateHz)
        putInt(SettingsLayout.width, width)
        putInt(SettingsLayout.height, height)
        putInt(SettingsLayout.markerType, markers.type.ordinal)
        putInt(SettingsLayout.markerDictionary, markers.dictionary)
        putInt(SettingsLayout.markerProfile, markers.profile)
        putInt(SettingsLayout.markerCamera, markers.camera)
        putFloat(SettingsLayout.markerLengthM, markers.lengthM)
        putInt(SettingsLayout.mapConfidence, map.leastConfidence)
        map.name.encodeToByteArray().forEachIndexed { i, byte -> put(SettingsLayout.map + i, byte) }
    }

    companion object {
        const val WANT_CONFIDENCE = 1
        const val WANT_FLAGS = 2
        const val WANT_RADIAL = 4

        /** Returns the settings of a camera. All its streams in the stream table share size and rate. */
        fun of(sensor: PixelSensor, backend: NativeBackend, subscriptions: List<Subscription>): NativeSettings {
            val values = subscriptions.first().values
            return NativeSettings(
                sensor.code,
                backend.code,
                subscriptions.map { it.stream }.bits(),
                subscriptions.filter { it.values.stream == 1 }.map { it.stream }.bits(),
                (if (values.confidence == true) WANT_CONFIDENCE else 0) or
                    (if (values.flags == true) WANT_FLAGS else 0) or
                    (if (values.radial == true) WANT_RADIAL else 0),
                values.rateHz ?: 0,
                values.width ?: 0,
                values.height ?: 0,
            )
        }
    }
}

/** The offsets of the fields of ml2s_settings, in bytes. */
private object SettingsLayout {
    private val offsets = Offsets(Native.settingsLayout())
    val sizeBytes = offsets.next()
    val sensor = offsets.next()
    val backend = offsets.next()
    val wants = offsets.next()
    val streams = offsets.next()
    val secondStreams = offsets.next()
    val rateHz = offsets.next()
    val width = offsets.next()
    val height = offsets.next()
    val markerType = offsets.next()
    val markerDictionary = offsets.next()
    val markerProfile = offsets.next()
    val markerCamera = offsets.next()
    val markerLengthM = offsets.next()
    val mapConfidence = offsets.next()
    val map = offsets.next()

    init {
        offsets.end()
    }
}
