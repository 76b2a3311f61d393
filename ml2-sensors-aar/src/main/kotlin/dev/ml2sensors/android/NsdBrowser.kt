package dev.ml2sensors.android

import android.content.Context
import android.content.res.Configuration
import android.net.nsd.NsdManager
import android.net.nsd.NsdServiceInfo
import android.net.wifi.WifiManager
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.ReceiverBrowser
import dev.ml2sensors.source.NoAnswerException
import dev.ml2sensors.source.PlatformCalls
import dev.ml2sensors.transport.Fingerprint
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.FlowCollector
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.withTimeoutOrNull
import java.io.IOException
import java.util.concurrent.ConcurrentHashMap
import java.util.concurrent.atomic.AtomicInteger
import java.util.concurrent.atomic.AtomicReference
import kotlin.time.Duration
import kotlin.time.Duration.Companion.seconds

/**
 * Returns the receiver that announces itself as [name] on the headset's network; without a name, the only one there is.
 * As the other `discover`, with Android's NsdManager.
 */
public fun Receiver.Companion.discover(context: Context, name: String? = null): Receiver =
    discover(nsdBrowser(context), name)

/** Returns a browser that gets an NsdManager only when the first search begins. */
internal fun nsdBrowser(context: Context, calls: PlatformCalls = PlatformCalls()): ReceiverBrowser {
    val app = context.applicationContext
    // A context keeps its NsdManager, so a replacement needs another context.
    val newManager = { app.createConfigurationContext(Configuration()).getSystemService(NsdManager::class.java) }
    return NsdBrowser(newManager, { app.getSystemService(WifiManager::class.java) }, calls = calls)
}

/**
 * Finds receivers with Android's NsdManager, as of API 29. It may not return from a call, or never answer a resolution,
 * and then that manager answers no later one either. So each has a limit. After it the search continues with a new
 * manager, and the receiver's last known address is used meanwhile.
 *
 * All searches share one manager, because nothing ends the thread and the connection to the system that each manager
 * has. At most [MAX_MANAGERS] are ever made; the last one stays, whether it answers or not.
 *
 * @param newManager is called on a thread of its own: Android's constructor waits for the system.
 * @param wifi is called on such a thread, too; returns null if no multicast lock is needed.
 */
internal class NsdBrowser(
    private val newManager: () -> NsdManager,
    private val wifi: () -> WifiManager?,
    private val resolutionLimit: Duration = RESOLUTION_LIMIT,
    private val calls: PlatformCalls = PlatformCalls(),
) : ReceiverBrowser {
    private val lastKnown = ConcurrentHashMap<String, ReceiverAddress>()
    private val present = AtomicReference<Manager?>()
    private val managersMade = AtomicInteger()

    /** An NsdManager, and its latest resolution, which may be unanswered, since a search can be cancelled meanwhile. */
    private inner class Manager(val nsd: NsdManager, number: Int) {
        private val latest = AtomicReference<Resolution?>()
        private val name = "Android's NsdManager $number"

        fun discover(search: Search) = calls.call(name, late = {
            if (!search.hasFailed) nsd.stopServiceDiscovery(search)
        }) {
            nsd.discoverServices(ReceiverBrowser.SERVICE_TYPE, NsdManager.PROTOCOL_DNS_SD, search)
        }

        /** While this has not returned, no other search begins. */
        fun stop(search: Search) {
            if (!search.hasFailed) calls.end(name) { nsd.stopServiceDiscovery(search) }
        }

        /**
         * Resolves [service]; the address is not completed if Android has not answered in time. One at a time, because
         * NsdManager refuses a second resolution until the first is answered.
         */
        suspend fun resolve(service: NsdServiceInfo): Resolution {
            val resolution = Resolution()
            do {
                val earlier = latest.get()
                if (earlier != null && !earlier.isAnswered()) return earlier
            } while (!latest.compareAndSet(earlier, resolution))
            try {
                calls.call(name) { nsd.resolveService(service, resolution) }
            } catch (_: NoAnswerException) {
                return resolution
            }
            resolution.isAnswered()
            return resolution
        }

        private suspend fun Resolution.isAnswered() =
            withTimeoutOrNull(resolutionLimit) { address.join() } != null
    }

    override fun receivers(): Flow<Map<String, ReceiverAddress>> = flow {
        val lock = acquireLock()
        try {
            while (true) searchUntilStuck()
        } finally {
            lock?.let(::releaseLock)
        }
    }

    /** Returns null if there is none: without it, some networks show no receivers. */
    private fun acquireLock() = try {
        calls.call(LOCK_CALL, late = { it?.release() }) { wifi()?.createMulticastLock(LOCK)?.apply { acquire() } }
    } catch (_: NoAnswerException) {
        null
    }

    private fun releaseLock(lock: WifiManager.MulticastLock) = try {
        calls.end(LOCK_CALL) { lock.release() }
    } catch (_: NoAnswerException) {
        // It is released when Android returns
    }

    /** Searches, and returns when the manager no longer answers. */
    private suspend fun FlowCollector<Map<String, ReceiverAddress>>.searchUntilStuck() {
        val manager = manager()
        val search = Search()
        try {
            manager.discover(search)
            search(manager, search)
        } catch (e: NoAnswerException) {
            replace(manager)
            throw e
        }
    }

    private suspend fun FlowCollector<Map<String, ReceiverAddress>>.search(manager: Manager, search: Search) {
        try {
            var found = emptyMap<String, ReceiverAddress>()
            for (sighting in search.sightings) {
                val name = sighting.service.serviceName
                val resolution = if (sighting.isLost) null else manager.resolve(sighting.service)
                val isStuck = resolution != null && !resolution.address.isCompleted
                val address = if (isStuck) lastKnown[name] else resolution?.address?.await()
                if (address != null) lastKnown[name] = address
                found = if (address == null) found - name else found + (name to address)
                if (isStuck) replace(manager) // before the collector may end the search
                emit(found)
                if (isStuck) return
            }
        } finally {
            try {
                manager.stop(search)
            } catch (_: NoAnswerException) { // Another one than this may be under way, as a cancellation
                replace(manager)
            }
        }
    }

    private fun manager(): Manager = present.get() ?: calls.call("a new NsdManager of Android") {
        Manager(newManager(), managersMade.incrementAndGet()).also { present.compareAndSet(null, it) }
    }

    private fun replace(stuck: Manager) {
        if (managersMade.get() < MAX_MANAGERS) present.compareAndSet(stuck, null)
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
        const val LOCK_CALL = "Android's lock for multicast"

        /** More than the receivers of any network; further ones are missed. */
        const val MAX_SIGHTINGS = 256

        /** Threads of managers that no longer answer, for the life of an app. */
        const val MAX_MANAGERS = 8

        /** RFC 6762, 6: answers arrive within 120 ms. A search of three seconds leaves time for a second manager. */
        val RESOLUTION_LIMIT = 1.seconds
    }
}
