package dev.ml2sensors.app.control

import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.app.status.StreamStatus
import kotlinx.serialization.Serializable
import kotlinx.serialization.json.Json

/**
 * A line of the reply to a command: JSON of less than 4 kB, the limit of logcat.
 *
 * @property request the extra `request` of the command.
 * @property more the number of lines of the same reply that follow.
 * @property error why the command was not carried out.
 */
@Serializable
internal class ReplyLine(
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

        /** Returns a line for the app, then one for each stream. */
        fun of(request: String, status: AppStatus): List<ReplyLine> {
            val count = status.streams.size
            val streams = status.streams.mapIndexed { i, it -> ReplyLine(request, more = count - 1 - i, stream = it) }
            return listOf(ReplyLine(request, more = count, status = status)) + streams
        }
    }
}
