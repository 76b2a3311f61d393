package dev.ml2sensors.app.status

import dev.ml2sensors.stream.StreamerStatus
import dev.ml2sensors.wire.Status
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class StreamStatusTest {
    @Test
    fun aStreamCountsMessagesOfItsFirstTopicAndLossesOfAllTopics() {
        val status = StreamerStatus(
            "connected",
            "desk",
            "",
            mapOf(
                "custom" to StreamerStatus.Stream("running"),
                "world_left" to StreamerStatus.Stream("running"),
                "depth" to StreamerStatus.Stream("refused", "no"),
            ),
            mapOf(
                "world_left/camera_info" to counts(9, "queue_full" to 1),
                "world_left/image_raw" to counts(10, "queue_full" to 2, "link_down" to 4),
                "world_right/image_raw" to counts(99, "queue_full" to 99),
                "custom/room" to counts(5),
            ),
        )
        val expected = listOf(
            streamStatus("world_left", produced = 10, dropped = 7, isPaused = true),
            streamStatus("depth", "refused", "no"),
            streamStatus("custom", produced = 5),
        )
        assertEquals(expected, status.byStream(paused = setOf("world_left")))
    }

    private fun counts(produced: Long, vararg dropped: Pair<String, Long>) =
        Status.ChannelCounts(produced, produced, mapOf(*dropped))
}
