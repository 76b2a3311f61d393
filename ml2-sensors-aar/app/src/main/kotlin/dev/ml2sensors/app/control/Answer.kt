package dev.ml2sensors.app.control

import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.StreamStatus
import kotlinx.serialization.Serializable
import kotlinx.serialization.json.Json

/**
 * A line of the answer to a command: JSON, short enough for logcat, which takes 4 kB.
 *
 * @property request repeats the extra `request` of the command.
 * @property more lines of the same answer are to come.
 * @property error why the command was not carried out.
 */
@Serializable
internal class Answer(
    private val request: String,
    private val more: Int = 0,
    private val error: String? = null,
    private val status: AppStatus? = null,
    private val stream: StreamStatus? = null,
) {
    override fun toString(): String = json.encodeToString(serializer(), this)

    companion object {
        private val json = Json {
            encodeDefaults = true
            explicitNulls = false
        }

        /** The app's line, then one for each stream. */
        fun of(request: String, status: AppStatus): List<Answer> {
            val count = status.streams.size
            val streams = status.streams.mapIndexed { i, it -> Answer(request, more = count - 1 - i, stream = it) }
            return listOf(Answer(request, more = count, status = status)) + streams
        }
    }
}
