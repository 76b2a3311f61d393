package dev.ml2sensors.android

import android.content.Context
import android.net.nsd.NsdManager
import android.net.nsd.NsdServiceInfo
import android.net.wifi.WifiManager
import dev.ml2sensors.link.Fingerprint
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ReceiverBrowser
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import java.io.IOException

/**
 * The receiver that announces itself by [name] on the headset's network, without a name the only one there is; as the
 * other `discover`, by Android's means.
 */
public fun Receiver.Companion.discover(context: Context, name: String? = null): Receiver =
    discover(nsdBrowser(context), name)

/** Android is asked for its NsdManager only when a search begins. */
internal fun nsdBrowser(context: Context): ReceiverBrowser {
    val app = context.applicationContext
    return ReceiverBrowser {
        val wifi = app.getSystemService(WifiManager::class.java)
        NsdBrowser(app.getSystemService(NsdManager::class.java), wifi).receivers()
    }
}

/** Looks with Android's NsdManager, as of API 29. Without a [wifi] there is no filter of multicast to lift. */
internal class NsdBrowser(private val nsd: NsdManager, private val wifi: WifiManager?) : ReceiverBrowser {
    override fun receivers(): Flow<Map<String, ReceiverAddress>> = flow {
        val search = Search()
        val lock = wifi?.createMulticastLock(LOCK)?.apply { acquire() }
        try {
            nsd.discoverServices(ReceiverBrowser.SERVICE_TYPE, NsdManager.PROTOCOL_DNS_SD, search)
            var found = emptyMap<String, ReceiverAddress>()
            for (sight in search.sights) {
                // One at a time: NsdManager refuses a second one meanwhile.
                val address = if (sight.isLost) null else resolve(sight.service)
                val name = sight.service.serviceName
                found = if (address == null) found - name else found + (name to address)
                emit(found)
            }
        } finally {
            if (!search.hasFailed) nsd.stopServiceDiscovery(search)
            lock?.release()
        }
    }

    /** Null for one that has gone meanwhile; the next search asks again. */
    private suspend fun resolve(service: NsdServiceInfo): ReceiverAddress? {
        val resolution = Resolution()
        nsd.resolveService(service, resolution)
        return resolution.address.await()
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
    }
}
