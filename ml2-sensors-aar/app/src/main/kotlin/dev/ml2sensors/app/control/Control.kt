package dev.ml2sensors.app.control

import dev.ml2sensors.app.Choices
import dev.ml2sensors.app.Streaming
import kotlinx.coroutines.CancellationException

/** Carries out what intents tell the service. */
internal class Control(private val streaming: Streaming, private val choices: Choices) {
    /** The lines to answer. The [request] stands in each. */
    suspend fun answer(request: String, action: String?, extra: (String) -> Any?): List<Answer> = try {
        val command = Command.parse(action, extra)
        carryOut(command)
        if (command == Command.Status) Answer.of(request, streaming.status()) else listOf(Answer(request))
    } catch (e: CancellationException) {
        throw e // It is an IllegalStateException
    } catch (e: Exception) {
        listOf(Answer(request, error = e.message ?: "$e")) // Whatever it is, who asked is told
    }

    private suspend fun carryOut(command: Command) {
        when (command) {
            Command.Resume -> if (choices.streams) start()

            Command.Start -> start()

            Command.Stop -> stop()

            Command.Status -> Unit

            is Command.Pair -> {
                streaming.pair(command.uri)
                start()
            }

            is Command.GoTo -> streaming.goTo(command.receiver)

            is Command.AtBoot -> choices.atBoot = command.on

            is Command.CoolDown -> choices.coolsDown = command.on
        }
    }

    private suspend fun start() {
        choices.streams = true
        streaming.start()
    }

    private suspend fun stop() {
        choices.streams = false
        streaming.stop()
    }
}
