package dev.ml2sensors.android

import android.content.Context
import android.content.res.Configuration
import android.net.nsd.NsdManager
import android.net.nsd.NsdServiceInfo
import android.net.wifi.WifiManager
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.transport.Fingerprint
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.util.concurrent.ConcurrentHashMap
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * The receiver that announces itself by [name] on the headset's network, without a name the only one there is; as the
 * other `discover`, by Android's means.
 */
public fun Receiver.Companion.discover(context: Context, name: String? = null): Receiver =
    discover(nsdBrowser(context), name)

/** Android is asked for an NsdManager only when a search begins. */
internal fun nsdBrowser(context: Context): ReceiverBrowser {
    val app = context.applicationContext
    // A context keeps its NsdManager, so another one needs another context.
    val newManager = { app.createConfigurationContext(Configuration()).getSystemService(NsdManager::class.java) }
    return NsdBrowser(newManager, app.getSystemService(WifiManager::class.java))
}

/**
 * Looks with Android's NsdManager, as of API 29. There, a resolution may never be answered, and then that manager
 * answers no later one either. So a resolution has [resolutionLimit]; after it a fresh manager begins the search again,
 * and the address that the receiver last had stands for it meanwhile.
 *
 * @param wifi null where there is no filter of multicast to lift.
 */
internal class NsdBrowser(
    private val newManager: () -> NsdManager,
    private val wifi: WifiManager?,
    private val resolutionLimit: Duration = RESOLUTION_LIMIT,
) : ReceiverBrowser {
    private val lastKnown = ConcurrentHashMap<String, ReceiverAddress>()

    override fun receivers(): Flow<Map<String, ReceiverAddress>> = flow {
        val lock = wifi?.createMulticastLock(LOCK)?.apply { acquire() }
        try {
            while (true) searchUntilStuck()
        } finally {
            lock?.release()
        }
    }

    /** Returns when the manager no longer answers. */
    private suspend fun FlowCollector<Map<String, ReceiverAddress>>.searchUntilStuck() {
        val nsd = newManager()
        val search = Search()
        try {
            nsd.discoverServices(ReceiverBrowser.SERVICE_TYPE, NsdManager.PROTOCOL_DNS_SD, search)
            var found = emptyMap<String, ReceiverAddress>()
            for (sight in search.sights) {
                val name = sight.service.serviceName
                // One at a time: NsdManager refuses a second one meanwhile.
                val resolution = if (sight.isLost) null else resolve(nsd, sight.service)
                val isStuck = resolution != null && !resolution.address.isCompleted
                val address = if (isStuck) lastKnown[name] else resolution?.address?.await()
                if (address != null) lastKnown[name] = address
                found = if (address == null) found - name else found + (name to address)
                emit(found)
                if (isStuck) return
            }
        } finally {
            if (!search.hasFailed) nsd.stopServiceDiscovery(search)
        }
    }

    /** Its address is not completed when Android has not answered in time. */
    private suspend fun resolve(nsd: NsdManager, service: NsdServiceInfo): Resolution {
        val resolution = Resolution()
        nsd.resolveService(service, resolution)
        withTimeoutOrNull(resolutionLimit) { resolution.address.join() }
        return resolution
    }

    private class Sight(val service: NsdServiceInfo, val isLost: Boolean)

    /** Called back by a thread of NsdManager. */
    private class Search : NsdManager.DiscoveryListener {
        val sights = Channel<Sight>(MOST_SIGHTS)

        @Volatile
        var hasFailed = false
            private set

        override fun onServiceFound(service: NsdServiceInfo) {
            sights.trySend(Sight(service, isLost = false))
        }

        override fun onServiceLost(service: NsdServiceInfo) {
            sights.trySend(Sight(service, isLost = true))
        }

        override fun onStartDiscoveryFailed(type: String, code: Int) {
            hasFailed = true
            sights.close(IOException("Android cannot look for receivers, NsdManager error $code"))
        }

        override fun onDiscoveryStarted(type: String) = Unit

        override fun onDiscoveryStopped(type: String) = Unit

        override fun onStopDiscoveryFailed(type: String, code: Int) = Unit
    }

    private class Resolution : NsdManager.ResolveListener {
        /** Null for a receiver that has gone meanwhile; the next search asks again. */
        val address = CompletableDeferred<ReceiverAddress?>()

        override fun onServiceResolved(service: NsdServiceInfo) {
            val host = service.host?.hostAddress
            val isWhole = host != null && service.port in 1..65535
            val announced = service.attributes[ReceiverBrowser.FINGERPRINT_KEY]?.decodeToString()
            address.complete(
                if (isWhole) ReceiverAddress(host, service.port, Fingerprint.orNull(announced)) else null,
            )
        }

        override fun onResolveFailed(service: NsdServiceInfo, code: Int) {
            address.complete(null)
        }
    }

    private companion object {
        const val LOCK = "ml2sensors"

        /** More receivers than any network has; a search that is flooded misses the rest. */
        const val MOST_SIGHTS = 256

        /** RFC 6762, 6: answers come within 120 ms. A search of three seconds has room for another manager. */
        val RESOLUTION_LIMIT = 1.seconds
    }
}
