package dev.ml2sensors.app.control

import dev.ml2sensors.pairing.PairingUri
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverBrowser
import kotlinx.coroutines.flow.emptyFlow

/** A command to the service, sent as an intent. */
internal sealed interface Command {
    /** Resume what the service did when its process died. */
    data object Resume : Command

    data object Start : Command

    data object Stop : Command

    data object Status : Command

    /** Pair with [uri], then stream. */
    class Pair(val uri: String) : Command

    /** Stream to [receiver], as described at `AppSettings.receiver`. */
    data class SetReceiver(val receiver: String) : Command

    data class SetStartAtBoot(val on: Boolean) : Command

    data class SetPauseWhenHot(val on: Boolean) : Command

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
         * Parses an intent's [action] and extras. Android sends a null action after the process has died.
         *
         * @throws IllegalArgumentException for anything else. The message never contains a pairing token.
         */
        fun parse(action: String?, extra: (String) -> Any?): Command = when (action) {
            null -> Resume

            START -> Start

            STOP -> Stop

            STATUS -> Status

            PAIR -> Pair(extra("uri").asText("uri").also(PairingUri::parse))

            RECEIVER -> SetReceiver(extra("receiver").asText("receiver").also { Receiver.parse(it, NO_BROWSER) })

            AT_BOOT -> SetStartAtBoot(extra("on").asFlag("on"))

            COOL_DOWN -> SetPauseWhenHot(extra("on").asFlag("on"))

            else -> throw IllegalArgumentException(
                "there is no action $action; expected one of ${ACTIONS.joinToString()}",
            )
        }

        private fun Any?.asText(name: String): String =
            requireNotNull(this as? String) { "expected the extra --es $name TEXT" }

        private fun Any?.asFlag(name: String): Boolean =
            requireNotNull(this as? Boolean) { "expected the extra --ez $name true or false" }

        private val ACTIONS = listOf(START, STOP, STATUS, PAIR, RECEIVER, AT_BOOT, COOL_DOWN).map {
            it.removePrefix(PREFIX)
        }

        private val NO_BROWSER = ReceiverBrowser { emptyFlow() }
    }
}
