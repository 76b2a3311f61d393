package dev.ml2sensors.simulator

import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.transport.Fingerprint
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.channels.awaitClose
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.callbackFlow
import kotlinx.coroutines.flow.conflate
import kotlinx.coroutines.flow.flowOn
import java.net.Inet4Address
import java.net.InetAddress
import java.net.NetworkInterface
import javax.jmdns.JmDNS
import javax.jmdns.ServiceEvent
import javax.jmdns.ServiceInfo
import javax.jmdns.ServiceListener
import kotlin.concurrent.thread
import kotlin.streams.asSequence

/** Finds receivers by mDNS on the networks of [interfaces], each given by an address of this machine. */
internal class MulticastBrowser(private val interfaces: List<InetAddress> = multicastInterfaces()) : ReceiverBrowser {
    override fun receivers(): Flow<Map<String, ReceiverAddress>> = callbackFlow {
        val listener = Listener { trySend(it) }
        val resolvers = mutableListOf<JmDNS>()
        try {
            interfaces.mapTo(resolvers) { JmDNS.create(it) }
            for (resolver in resolvers) resolver.addServiceListener("${ReceiverBrowser.SERVICE_TYPE}.local.", listener)
            awaitClose()
        } finally {
            // JmDNS takes two seconds to close: it waits for goodbyes of services, of which there are none
            thread(isDaemon = true) { resolvers.forEach(JmDNS::close) }
        }
    }.conflate().flowOn(Dispatchers.IO)

    private class Listener(private val changed: (Map<String, ReceiverAddress>) -> Unit) : ServiceListener {
        private val found = mutableMapOf<String, ReceiverAddress>()

        override fun serviceAdded(event: ServiceEvent) = event.dns.requestServiceInfo(event.type, event.name)

        @Synchronized
        override fun serviceResolved(event: ServiceEvent) {
            found[event.name] = address(event.info) ?: return
            changed(found.toMap())
        }

        @Synchronized
        override fun serviceRemoved(event: ServiceEvent) {
            found -= event.name
            changed(found.toMap())
        }
    }
}

private fun address(service: ServiceInfo): ReceiverAddress? {
    val host = (service.inet4Addresses.toList<InetAddress>() + service.inet6Addresses).firstOrNull() ?: return null
    val fingerprint = Fingerprint.orNull(service.getPropertyString(ReceiverBrowser.FINGERPRINT_KEY))
    return service.port.takeIf { it in 1..65535 }?.let { ReceiverAddress(host.hostAddress, it, fingerprint) }
}

/** Returns an IPv4 address of every network, or only the address in JmDNS's own property. */
private fun multicastInterfaces(): List<InetAddress> =
    System.getProperty("net.mdns.interface")?.let { listOf(InetAddress.getByName(it)) }
        ?: NetworkInterface.networkInterfaces().asSequence()
            .filter { it.isUp && (it.supportsMulticast() || it.isLoopback) }
            .mapNotNull { network -> network.inetAddresses().asSequence().firstOrNull { it is Inet4Address } }
            .toList()
