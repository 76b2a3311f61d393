package dev.ml2sensors.capture

import dev.ml2sensors.source.MapSample
import dev.ml2sensors.source.MapState
import dev.ml2sensors.source.StreamValues

/** The map to localize in: the map fields of ml2s_settings. */
internal data class MapSettings(val name: String = "", val leastConfidence: Int = 0) {
    companion object {
        private val STATES = listOf("not_localized", "localized", "pending", "sleeping_before_retry")
        private val TYPES = listOf("on_device", "cloud")
        private val ERRORS =
            listOf("unknown", "out_of_mapped_area", "low_feature_count", "excessive_motion", "low_light", "headpose")

        /** The size of the name in ml2s_settings, without the zero at its end. */
        private const val MOST_BYTES = 63

        /**
         * Returns the settings for a stream's [values], with the defaults of the stream table for missing ones.
         *
         * @throws IllegalArgumentException for a value that the stream does not have.
         */
        fun of(values: StreamValues): MapSettings {
            val name = values.localize.orEmpty()
            require(name.encodeToByteArray().size <= MOST_BYTES) { "localize: expected at most $MOST_BYTES bytes" }
            return MapSettings(name, knownIndex("min_confidence", values.minConfidence ?: "fair", MapState.CONFIDENCES))
        }

        fun sample(found: Reading): MapSample {
            val (uuid, name) = found.name.split(" ", limit = 2).let { it.first() to it.drop(1).joinToString() }
            return MapSample(
                found.captureNanos,
                found.pose?.toBody(),
                MapState(
                    word(STATES, found.value(Reading.MAP_STATE)),
                    word(MapState.CONFIDENCES, found.value(Reading.MAP_CONFIDENCE)),
                    wordsOf(ERRORS, found.value(Reading.MAP_ERRORS).toInt()),
                    name,
                    uuid,
                    if (uuid.isEmpty()) "" else word(TYPES, found.value(Reading.MAP_TYPE)),
                ),
            )
        }

        private fun word(words: List<String>, number: Float) = words.getOrElse(number.toInt()) { "unknown" }
    }
}
