package dev.ml2sensors.app.control

import dev.ml2sensors.app.AppSettings
import dev.ml2sensors.app.StreamController
import kotlinx.coroutines.CancellationException

/** Carries out commands and makes the replies. */
internal class CommandHandler(private val streaming: StreamController, private val settings: AppSettings) {
    /** Carries out the command of an intent and returns the lines of the reply, each with [request]. */
    suspend fun reply(request: String, action: String?, extra: (String) -> Any?): List<ReplyLine> = try {
        val command = Command.parse(action, extra)
        execute(command)
        if (command == Command.Status) ReplyLine.of(request, streaming.status()) else listOf(ReplyLine(request))
    } catch (e: CancellationException) {
        throw e // CancellationException is an IllegalStateException
    } catch (e: Exception) {
        listOf(ReplyLine(request, error = e.message ?: "$e")) // The sender of the command gets every error
    }

    private suspend fun execute(command: Command) {
        when (command) {
            Command.Resume -> if (settings.isStreaming) start()

            Command.Start -> start()

            Command.Stop -> stop()

            Command.Status -> Unit

            is Command.Pair -> {
                streaming.pair(command.uri)
                start()
            }

            is Command.SetReceiver -> streaming.setReceiver(command.receiver)

            is Command.SetStartAtBoot -> settings.startAtBoot = command.on

            is Command.SetPauseWhenHot -> settings.pauseWhenHot = command.on
        }
    }

    private suspend fun start() {
        settings.isStreaming = true
        streaming.start()
    }

    private suspend fun stop() {
        settings.isStreaming = false
        streaming.stop()
    }
}
