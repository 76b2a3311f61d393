package dev.ml2sensors.session

import dev.ml2sensors.wire.printable
import kotlinx.coroutines.FlowPreview
import kotlinx.coroutines.flow.debounce
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.flow.onEach
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/** Finds the receiver [name] with [browser], or without a name the only one. */
internal class DiscoveredReceiver(private val browser: ReceiverBrowser, private val name: String?) : Receiver {
    @OptIn(FlowPreview::class)
    override suspend fun locate(): ReceiverAddress {
        var found = emptyMap<String, ReceiverAddress>()
        withTimeoutOrNull(PATIENCE) {
            val receivers = browser.receivers().onEach { found = it }
            if (name == null) receivers.debounce(SETTLING).first { it.isNotEmpty() } else receivers.first { name in it }
        }
        val address = if (name == null) found.values.singleOrNull() else found[name]
        return address ?: throw IOException(failure(printable(found.keys.sorted().joinToString())))
    }

    /** @param found the names that anybody on the network may announce, fit to be shown. */
    private fun failure(found: String): String = when {
        found.isEmpty() -> "no receiver announces itself on this network; connect by its address instead"
        name == null -> "several receivers announce themselves, choose one by its name: $found"
        else -> "no receiver announces itself as '$name', only $found"
    }

    override fun toString(): String = if (name == null) "any receiver" else "receiver '$name'"

    private companion object {
        /** A search waits for this long for a receiver that is just starting. */
        val PATIENCE = 3.seconds

        /** RFC 6762, 6: answers come within 120 ms. */
        val SETTLING = 250.milliseconds
    }
}
