package dev.ml2sensors.app.control

import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverBrowser
import kotlinx.coroutines.flow.emptyFlow

/** What the service is told by an intent. */
internal sealed interface Command {
    /** To do what was being done when the process died. */
    data object Resume : Command

    data object Start : Command

    data object Stop : Command

    data object Status : Command

    /** To pair as of [uri], and to stream. */
    class Pair(val uri: String) : Command

    /** The [receiver] to stream to, as of `Choices.receiver`. */
    data class GoTo(val receiver: String) : Command

    data class AtBoot(val on: Boolean) : Command

    data class CoolDown(val on: Boolean) : Command

    companion object {
        private const val PREFIX = "dev.ml2sensors.app."
        const val START: String = "${PREFIX}START"
        const val STOP: String = "${PREFIX}STOP"
        const val STATUS: String = "${PREFIX}STATUS"
        const val PAIR: String = "${PREFIX}PAIR"
        const val RECEIVER: String = "${PREFIX}RECEIVER"
        const val AT_BOOT: String = "${PREFIX}AT_BOOT"
        const val COOL_DOWN: String = "${PREFIX}COOL_DOWN"

        /**
         * The command of an intent's [action] and extras; Android gives a null action after the process has died.
         *
         * @throws IllegalArgumentException for anything else, in words that do not repeat a secret.
         */
        fun parse(action: String?, extra: (String) -> Any?): Command = when (action) {
            null -> Resume
            START -> Start
            STOP -> Stop
            STATUS -> Status
            PAIR -> Pair(extra("uri").asText("uri").also(PairingUri::parse))
            RECEIVER -> GoTo(extra("receiver").asText("receiver").also { Receiver.parse(it, NOBODY) })
            AT_BOOT -> AtBoot(extra("on").asFlag("on"))
            COOL_DOWN -> CoolDown(extra("on").asFlag("on"))
            else -> throw IllegalArgumentException("there is no action $action")
        }

        private fun Any?.asText(name: String): String =
            requireNotNull(this as? String) { "expected the extra --es $name TEXT" }

        private fun Any?.asFlag(name: String): Boolean =
            requireNotNull(this as? Boolean) { "expected the extra --ez $name true or false" }

        private val NOBODY = ReceiverBrowser { emptyFlow() }
    }
}
