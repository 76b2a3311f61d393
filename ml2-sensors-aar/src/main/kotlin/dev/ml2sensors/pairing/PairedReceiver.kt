package dev.ml2sensors.pairing

import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.transport.Fingerprint
import dev.ml2sensors.transport.NotPairedException
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.FlowPreview
import kotlinx.coroutines.flow.debounce
import kotlinx.coroutines.flow.firstOrNull
import kotlinx.coroutines.flow.mapNotNull
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import kotlin.time.Duration.Companion.milliseconds
import kotlin.time.Duration.Companion.seconds

/**
 * A receiver that this device is paired with.
 *
 * @property name the name that it announces.
 * @property fingerprint of its certificate.
 * @property address where it served sessions when they were paired, with its fingerprint.
 */
public data class PairedReceiver(val name: String, val fingerprint: Fingerprint, val address: ReceiverAddress)

/**
 * Locates the paired receiver that announces itself; if none does, uses the address at which the latest one was paired.
 *
 * A search that finds nothing delays a connection, so the first is short. Each later one takes twice as long, up to
 * [LONGEST_SEARCH], because multicast may be slow and the receiver's address may have changed.
 *
 * @param load reads the paired receivers.
 */
internal class PairedReceiverLocator(
    private val load: () -> List<PairedReceiver>,
    private val browser: ReceiverBrowser,
) :
    Receiver {
    @Volatile
    private var search = SHORTEST_SEARCH

    /**
     * Returns its present address.
     *
     * @throws NotPairedException when the device is not paired.
     */
    override suspend fun locate(): ReceiverAddress {
        val paired = withContext(Dispatchers.IO) { load() }
        if (paired.isEmpty()) throw NotPairedException("any receiver")
        val announced = announced(paired)
        search = if (announced != null) SHORTEST_SEARCH else minOf(search * 2, LONGEST_SEARCH)
        return announced ?: paired.last().address
    }

    @OptIn(FlowPreview::class)
    private suspend fun announced(paired: List<PairedReceiver>): ReceiverAddress? = try {
        withTimeoutOrNull(search) {
            browser.receivers().debounce(SETTLING).mapNotNull { found ->
                paired.reversed().firstNotNullOfOrNull { known ->
                    found.values.firstOrNull { it.fingerprint == known.fingerprint }
                }
            }.firstOrNull()
        }
    } catch (_: IOException) {
        null // The address is left if looking is impossible
    }

    override fun toString(): String = "the paired receiver"

    private companion object {
        /** RFC 6762, 6: answers come within 120 ms. */
        val SETTLING = 150.milliseconds
        val SHORTEST_SEARCH = 500.milliseconds
        val LONGEST_SEARCH = 4.seconds
    }
}
