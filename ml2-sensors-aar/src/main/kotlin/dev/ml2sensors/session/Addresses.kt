package dev.ml2sensors.session

import dev.ml2sensors.transport.TransportException
import java.io.IOException
import java.net.ConnectException
import java.net.InetAddress
import java.net.InetSocketAddress
import java.net.UnknownHostException

/** Resolves [host], a name or an address. */
internal fun addressesOf(host: String): List<InetAddress> = try {
    InetAddress.getAllByName(host).toList()
} catch (e: UnknownHostException) {
    throw UnknownHostException("no address is known for $host").apply { initCause(e) }
}

/**
 * Calls [connect] with one of [addresses] after the other, and returns the first result. [connect] gets a time limit
 * for the TCP connection in ms, so that an address that does not answer leaves time for the others; 0 means no limit,
 * for the last one. IPv6 and IPv4 alternate as in RFC 8305, 4, beginning with the family of the first address.
 *
 * @throws IOException if all fail: the only error, or the one of a machine that is not the receiver, or a summary.
 */
internal fun <T> firstThatAnswers(
    receiver: ReceiverAddress,
    addresses: List<InetAddress>,
    connect: (InetSocketAddress, limitMillis: Int) -> T,
): T {
    val tried = inTurn(addresses).take(MOST_ADDRESSES)
    val failures = LinkedHashMap<InetAddress, IOException>()
    for (address in tried) {
        try {
            val limitMillis = if (address == tried.last()) 0 else ATTEMPT_LIMIT_MILLIS
            return connect(InetSocketAddress(address, receiver.port), limitMillis)
        } catch (e: IOException) {
            if (Thread.currentThread().isInterrupted) throw e
            failures[address] = e
        }
    }
    failures.values.singleOrNull()?.let { throw it }
    failures.values.firstOrNull { it is TransportException }?.let { throw it }
    val each = failures.entries.joinToString("; ") { (address, failure) ->
        "${address.hostAddress}: ${failure.message}"
    }
    throw ConnectException("no address of $receiver answers ($each)")
}

private fun inTurn(addresses: List<InetAddress>): List<InetAddress> {
    val (firsts, others) = addresses.distinct().partition { it.javaClass == addresses.first().javaClass }
    return (0 until maxOf(firsts.size, others.size)).flatMap {
        listOfNotNull(firsts.getOrNull(it), others.getOrNull(it))
    }
}

/** With [ATTEMPT_LIMIT_MILLIS] this leaves the last address two of the five seconds for a connection. */
private const val MOST_ADDRESSES = 4
private const val ATTEMPT_LIMIT_MILLIS = 1_000
