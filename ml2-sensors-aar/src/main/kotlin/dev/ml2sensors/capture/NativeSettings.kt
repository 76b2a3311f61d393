package dev.ml2sensors.capture

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
) {
    fun open(): Long = Native.open(sensor, backend, wants, streams, secondStreams, rateHz, width, height)

    fun configure(handle: Long): Unit =
        Native.configure(handle, sensor, backend, wants, streams, secondStreams, rateHz, width, height)

    companion object {
        const val WANT_CONFIDENCE = 1
        const val WANT_FLAGS = 2
        const val WANT_RADIAL = 4

        /** Of a camera; its size and rate are one for all its streams in the stream table. */
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
