package dev.ml2sensors.source

import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class NegotiationTest {
    @Test
    fun everyModeOfTheTableIsTaken() {
        for (stream in StreamTable.all) {
            for (mode in stream.modes) {
                for (rate in mode.rates) {
                    for ((width, height) in mode.resolutions) {
                        val values = StreamValues(mode.stream, width, height, rate, mode.formats.last())
                        val answer = stream.answer(values)
                        assertEquals(Answer.Applied(values), answer)
                    }
                }
            }
            if (stream.modes.isEmpty()) assertEquals(Answer.Applied(StreamValues()), stream.answer(StreamValues()))
        }
    }

    @Test
    fun aRefusalNamesTheValueAndWhatWouldDo() {
        assertRefused("update_rate is 60, expected one of 15, 30", COLOR.copy(width = 4096, height = 3072, rateHz = 60))
        assertRefused("format is png, expected one of jpeg, h264, h264_foxglove", COLOR.copy(format = "png"))
        assertRefused("stream is null, expected one of 0, 1", COLOR.copy(stream = null))
        assertRefused(
            "resolution is 1920x1081, expected one of 640x480, 1280x720, 1280x960, 1440x1080, 1920x1080, 2048x1536, " +
                "2880x2160, 3840x2160, 4096x3072",
            COLOR.copy(height = 1081),
        )
    }

    private fun assertRefused(reason: String, values: StreamValues) =
        assertEquals(Answer.Refused(reason), StreamTable.color.answer(values))

    private companion object {
        val COLOR = StreamValues(0, 1920, 1080, 30, "jpeg")
    }
}
