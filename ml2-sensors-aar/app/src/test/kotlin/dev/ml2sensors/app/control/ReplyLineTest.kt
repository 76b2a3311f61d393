package dev.ml2sensors.app.control

import dev.ml2sensors.app.status.appStatus
import dev.ml2sensors.app.status.streamStatus
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Status
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.int
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertTrue

class ReplyLineTest {
    @Test
    fun successIsOneLine() = assertEquals("""{"request":"7","more":0}""", "${ReplyLine("7")}")

    @Test
    fun anErrorHasItsReason() = assertEquals(
        """{"request":"","more":0,"error":"no"}""",
        "${ReplyLine("", error = "no")}",
    )

    @Test
    fun aStatusIsALineForTheAppAndOneForEachStream() {
        val streams = listOf(streamStatus("depth", produced = 5, dropped = 1), streamStatus("gaze", "refused", "no"))
        val (app, depth, gaze) = ReplyLine.of("7", appStatus(streams = streams)).map { json("$it") }
        assertEquals(listOf(2, 1, 0), listOf(app, depth, gaze).map { it.getValue("more").jsonPrimitive.int })
        assertEquals(setOf("request", "more", "status"), app.keys)
        val keys = setOf(
            "version", "state", "receiver", "reason", "news", "paired", "permissions", "thermal", "at_boot",
            "cools_down",
        )
        assertEquals(keys, app.getValue("status").jsonObject.keys)
        val expected = """{"id":"depth","state":"running","reason":"","produced":5,"dropped":1,"resting":false}"""
        assertEquals(expected, depth.getValue("stream").toString())
        assertEquals("gaze", gaze.getValue("stream").jsonObject.getValue("id").jsonPrimitive.content)
    }

    /** The test of `ml2-receiver headset` reads the same lines. */
    @Test
    fun aStatusIsWhatTheReceiverReads() {
        val denied = "com.magicleap.permission.DEPTH_CAMERA"
        val status = appStatus(
            streams = listOf(
                streamStatus("world_left", produced = 900, dropped = 2, isPaused = true),
                streamStatus("depth", "refused", "$denied is not granted"),
            ),
            permissions = mapOf("android.permission.CAMERA" to true, denied to false),
            lastResult = "paired with desk",
            clock = Status.Clock("synchronised", -5, 58_000, 110_000, 0.5, 0, 1, mapOf("head_pose" to "boottime")),
            thermal = "light",
            batteryCelsius = 31.5,
        )
        val lines = checkNotNull(javaClass.getResource("/status.jsonl")).readText().trim().lines()
        assertEquals(lines, ReplyLine.of("7", status).map { "$it" })
    }

    @Test
    fun everyLineFitsLogcat() {
        val long = "x".repeat(200)
        val streams = StreamTable.all.map { streamStatus(it.id, "refused", long, Long.MAX_VALUE, Long.MAX_VALUE) }
        val status = appStatus(
            streams = streams,
            permissions = StreamTable.all.flatMap { it.permissions }.associateWith { true },
            reason = long,
            lastResult = long,
            paired = List(8) { "r".repeat(64) },
            clock = Status.Clock(
                "synchronised",
                Long.MIN_VALUE,
                Long.MAX_VALUE,
                Long.MAX_VALUE,
                -1e-9,
                Long.MAX_VALUE,
                Long.MAX_VALUE,
                StreamTable.all.associate { it.id to "monotonic" },
            ),
        )
        for (line in ReplyLine.of("x".repeat(36), status)) assertTrue("$line".length < 4_000, "${"$line".length}")
    }

    private fun json(line: String): JsonObject = Json.parseToJsonElement(line).jsonObject
}
