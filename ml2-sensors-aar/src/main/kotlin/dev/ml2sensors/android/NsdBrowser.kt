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
import kotlinx.coroutines.sync.Mutex
import kotlinx.coroutines.sync.withLock
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.util.concurrent.ConcurrentHashMap
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * Returns the receiver that announces itself as [name] on the headset's network; without a name, the only one there is.
 * As the other `discover`, with Android's NsdManager.
 */
public fun Receiver.Companion.discover(context: Context, name: String? = null): Receiver =
    discover(nsdBrowser(context), name)

/** Returns a browser that gets an NsdManager only when the first search begins. */
internal fun nsdBrowser(context: Context): ReceiverBrowser {
    val app = context.applicationContext
    // A context keeps its NsdManager, so a replacement needs another context.
    val newManager = { app.createConfigurationContext(Configuration()).getSystemService(NsdManager::class.java) }
    return NsdBrowser(newManager, app.getSystemService(WifiManager::class.java))
}

/**
 * Finds receivers with Android's NsdManager, as of API 29. A resolution may never be answered, and then that manager
 * answers no later one either. So each resolution has a [resolutionLimit]. After it the search continues with a new
 * manager, and the receiver's last known address is used meanwhile.
 *
 * All searches share one manager, because nothing ends the thread and the connection to the system that each manager
 * has. At most [MAX_MANAGERS] are ever made; the last one stays, whether it answers or not.
 *
 * @param wifi null if no multicast lock is needed.
 */
internal class NsdBrowser(
    private val newManager: () -> NsdManager,
    private val wifi: WifiManager?,
    private val resolutionLimit: Duration = RESOLUTION_LIMIT,
) : ReceiverBrowser {
    private val lastKnown = ConcurrentHashMap<String, ReceiverAddress>()
    private val resolving = Mutex()
    private var manager: NsdManager? = null
    private var managersMade = 0

    /** The latest resolution of [manager]. It may be unanswered, since a search can be cancelled meanwhile. */
    private var latest: Resolution? = null

    override fun receivers(): Flow<Map<String, ReceiverAddress>> = flow {
        val lock = wifi?.createMulticastLock(LOCK)?.apply { acquire() }
        try {
            while (true) searchUntilStuck()
        } finally {
            lock?.release()
        }
    }

    /** Searches, and returns when the manager no longer answers. */
    private suspend fun FlowCollector<Map<String, ReceiverAddress>>.searchUntilStuck() {
        val nsd = manager()
        val search = Search()
        try {
            nsd.discoverServices(ReceiverBrowser.SERVICE_TYPE, NsdManager.PROTOCOL_DNS_SD, search)
            var found = emptyMap<String, ReceiverAddress>()
            for (sighting in search.sightings) {
                val name = sighting.service.serviceName
                val resolution = if (sighting.isLost) null else resolve(nsd, sighting.service)
                val isStuck = resolution != null && !resolution.address.isCompleted
                val address = if (isStuck) lastKnown[name] else resolution?.address?.await()
                if (address != null) lastKnown[name] = address
                found = if (address == null) found - name else found + (name to address)
                emit(found)
                if (isStuck) return replace(nsd)
            }
        } finally {
            if (!search.hasFailed) nsd.stopServiceDiscovery(search)
        }
    }

    @Synchronized
    private fun manager(): NsdManager = manager ?: newManager().also {
        manager = it
        managersMade++
    }

    @Synchronized
    private fun replace(stuck: NsdManager) {
        if (manager !== stuck || managersMade == MAX_MANAGERS) return
        manager = null
        latest = null
    }

    /**
     * Resolves [service]; the address is not completed if Android has not answered in time. One at a time, because
     * NsdManager refuses a second resolution until the first is answered.
     */
    private suspend fun resolve(nsd: NsdManager, service: NsdServiceInfo): Resolution = resolving.withLock {
        latest?.let { earlier ->
            withTimeoutOrNull(resolutionLimit) { earlier.address.join() } ?: return earlier
        }
        val resolution = Resolution().also { latest = it }
        nsd.resolveService(service, resolution)
        withTimeoutOrNull(resolutionLimit) { resolution.address.join() }
        resolution
    }

    private class Sighting(val service: NsdServiceInfo, val isLost: Boolean)

    /** Receives the callbacks of one search, on a thread of NsdManager. */
    private class Search : NsdManager.DiscoveryListener {
        val sightings = Channel<Sighting>(MAX_SIGHTINGS)

        @Volatile
        var hasFailed = false
            private set

        override fun onServiceFound(service: NsdServiceInfo) {
            sightings.trySend(Sighting(service, isLost = false))
        }

        override fun onServiceLost(service: NsdServiceInfo) {
            sightings.trySend(Sighting(service, isLost = true))
        }

        override fun onStartDiscoveryFailed(type: String, code: Int) {
            hasFailed = true
            sightings.close(IOException("Android cannot look for receivers, NsdManager error $code"))
        }

        override fun onDiscoveryStarted(type: String) = Unit

        override fun onDiscoveryStopped(type: String) = Unit

        override fun onStopDiscoveryFailed(type: String, code: Int) = Unit
    }

    private class Resolution : NsdManager.ResolveListener {
        /** The address, or null if the receiver has gone meanwhile; the next search resolves it again. */
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

        /** More than the receivers of any network; further ones are missed. */
        const val MAX_SIGHTINGS = 256

        /** Threads of managers that no longer answer, for the life of an app. */
        const val MAX_MANAGERS = 8

        /** RFC 6762, 6: answers arrive within 120 ms. A search of three seconds leaves time for a second manager. */
        val RESOLUTION_LIMIT = 1.seconds
    }
}
