package dev.ml2sensors.capture

import dev.ml2sensors.source.Marker
import dev.ml2sensors.source.StreamValues
import java.security.MessageDigest

/** The kinds of markers, in the order of XrMarkerTypeML; the dictionaries of each in that of OpenXR. */
internal enum class MarkerType(val id: String, val dictionaries: List<String>) {
    ARUCO("aruco", (4..7).flatMap { cells -> listOf(50, 100, 250, 1000).map { "${cells}X${cells}_$it" } }),
    APRIL_TAG("april_tag", listOf("16h5", "25h9", "36h10", "36h11")),
    QR("qr", emptyList()),
}

/** The markers that the detector looks for: the marker fields of ml2s_settings, with the numbers of OpenXR. */
internal data class MarkerSettings(
    val type: MarkerType = MarkerType.ARUCO,
    val dictionary: Int = 0,
    val profile: Int = 0,
    val camera: Int = 0,
    val lengthM: Float = 0f,
) {
    /** Returns the marker of a reading: what other programs for such markers call its frame, and its pose. */
    fun marker(found: Reading): Marker? {
        val pose = found.pose?.toMarker() ?: return null
        val content = if (type == MarkerType.QR) found.name else found.id.toString()
        val frame = when (type) {
            MarkerType.ARUCO -> "marker_$content"
            MarkerType.APRIL_TAG -> "tag${type.dictionaries[dictionary]}:$content"
            MarkerType.QR -> "qr_${hash(content)}"
        }
        return Marker(
            frame,
            content,
            pose,
            found.value(Reading.MARKER_LENGTH_M).toDouble(),
            found.value(Reading.MARKER_REPROJECTION_ERROR_M).toDouble(),
        )
    }

    companion object {
        private val PROFILES = listOf("default", "speed", "accuracy", "small_targets", "large_fov")
        private val CAMERAS = listOf("auto", "world", "rgb")
        private const val DEFAULT_SIZE_M = 0.16
        private const val HASH_BYTES = 4

        /**
         * Returns the settings for a stream's [values], with the defaults of the stream table for missing ones.
         *
         * @throws IllegalArgumentException for a value that the detector does not have.
         */
        fun of(values: StreamValues): MarkerSettings {
            val kinds = MarkerType.entries.map { it.id }
            val type = MarkerType.entries[knownIndex("type", values.markerType ?: "april_tag", kinds)]
            val dictionary = values.dictionary ?: if (type == MarkerType.APRIL_TAG) "36h11" else "5X5_100"
            val size = values.sizeM ?: DEFAULT_SIZE_M
            require(size > 0 && size.isFinite()) { "size_m is $size, expected a length above 0" }
            return MarkerSettings(
                type,
                if (type == MarkerType.QR) 0 else knownIndex("dictionary", dictionary, type.dictionaries),
                knownIndex("profile", values.profile ?: PROFILES.first(), PROFILES),
                knownIndex("camera", values.camera ?: CAMERAS.first(), CAMERAS),
                size.toFloat(),
            )
        }

        /** Returns the first eight digits of the SHA-1 of [text], since frame ids are no free text. */
        private fun hash(text: String): String = MessageDigest.getInstance("SHA-1")
            .digest(text.encodeToByteArray())
            .take(HASH_BYTES)
            .joinToString("") { "%02x".format(it) }
    }
}

/** Returns the place of the [value] of [key] in [known]; throws IllegalArgumentException if it is not there. */
internal fun knownIndex(key: String, value: String, known: List<String>): Int = known.indexOf(value).also {
    require(it >= 0) { "$key is $value, expected one of ${known.joinToString()}" }
}
