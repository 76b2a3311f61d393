package dev.ml2sensors.unity

import dev.ml2sensors.TEST_LIMIT
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.JsonObject
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.robolectric.RuntimeEnvironment
import java.io.Closeable
import java.util.concurrent.LinkedBlockingQueue
import java.util.concurrent.TimeUnit
import kotlin.test.assertNotNull

/** Unity's side of [unity]. */
internal class UnityProbe : Ml2UnityListener, Closeable {
    private val changes = LinkedBlockingQueue<JsonObject>()
    val unity = Ml2Unity.open(RuntimeEnvironment.getApplication(), this)

    override fun changed(statusJson: String) {
        changes += Json.parseToJsonElement(statusJson).jsonObject
    }

    fun status() = Json.parseToJsonElement(unity.status()).jsonObject

    /** The first status that the listener is told of, since the last one awaited, that is so. */
    fun await(isSo: (JsonObject) -> Boolean): JsonObject {
        while (true) {
            val change =
                assertNotNull(
                    changes.poll(TEST_LIMIT.inWholeMilliseconds, TimeUnit.MILLISECONDS),
                    "found ${unity.status()}",
                )
            if (isSo(change)) return change
        }
    }

    override fun close(): Unit = unity.close()

    companion object {

        val JsonObject.state get() = text("state")
        val JsonObject.streams get() = getValue("streams").jsonObject
        val JsonObject.pairing get() = getValue("pairing").jsonObject

        fun JsonObject.text(key: String) = getValue(key).jsonPrimitive.content
    }
}
