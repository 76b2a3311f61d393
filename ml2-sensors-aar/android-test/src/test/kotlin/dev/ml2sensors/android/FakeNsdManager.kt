package dev.ml2sensors.android

import android.content.Context
import android.net.nsd.INsdManager
import android.net.nsd.NsdManager
import android.net.nsd.NsdServiceInfo
import android.net.wifi.WifiManager
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.channels.trySendBlocking
import org.robolectric.annotation.Implementation
import org.robolectric.annotation.Implements
import org.robolectric.shadows.ShadowWifiManager
import java.net.InetAddress
import java.util.concurrent.atomic.AtomicInteger
import kotlin.test.assertEquals
import kotlin.test.assertNull
import kotlin.test.assertTrue

/** A network of services; refuses what Android 10 refuses: a second resolution, and listeners it does not know. */
@Implements(NsdManager::class)
class FakeNsdManager {
    private val services = linkedMapOf<String, NsdServiceInfo>()
    private val resolutions = Channel<() -> Unit>(Channel.UNLIMITED)
    private val usedListeners = mutableSetOf<Any>()
    private val searches = mutableListOf<NsdManager.DiscoveryListener>()
    private var resolving: String? = null

    var type: String? = null
        private set
    var refusal: Int? = null
    var isSlow = false
    val unresolvable = mutableSetOf<String>()
    val isSearching: Boolean @Synchronized get() = searches.isNotEmpty()

    fun appear(name: String, host: String, port: Int) {
        val service = NsdServiceInfo().also {
            it.serviceName = name
            it.host = InetAddress.getByName(host)
            it.port = port
        }
        changed { services[name] = service }.forEach { it.onServiceFound(unresolved(name)) }
    }

    fun vanish(name: String): Unit = changed { services -= name }.forEach { it.onServiceLost(unresolved(name)) }

    /** Returns who is told of [change], by this thread and without the lock: they may ask at once. */
    private fun changed(change: () -> Unit) = synchronized(this) {
        change()
        searches.toList()
    }

    /** Android's own asks a service that is not here. */
    @Implementation
    @Suppress("FunctionName", "UNUSED_PARAMETER")
    fun __constructor__(context: Context, service: INsdManager) {
        NeverReturns.pass("NsdManager.constructor")
        onConstructed(this)
    }

    /** Answers the oldest resolution, once it is asked for. */
    suspend fun resolveNext() = resolutions.receive()()

    /** Answers the resolutions that were asked for. */
    fun resolveAll() {
        while (true) (resolutions.tryReceive().getOrNull() ?: return)()
    }

    @Implementation
    fun discoverServices(serviceType: String, protocol: Int, listener: NsdManager.DiscoveryListener) {
        NeverReturns.pass("NsdManager.discoverServices")
        assertEquals(NsdManager.PROTOCOL_DNS_SD, protocol)
        discover(serviceType, listener)
    }

    private fun discover(serviceType: String, listener: NsdManager.DiscoveryListener) {
        type = serviceType
        refusal?.let { return listener.onStartDiscoveryFailed(serviceType, it) }
        val names = synchronized(this) {
            searches += listener
            services.keys.toList()
        }
        listener.onDiscoveryStarted(serviceType)
        names.forEach { listener.onServiceFound(unresolved(it)) }
    }

    @Implementation
    fun stopServiceDiscovery(listener: NsdManager.DiscoveryListener) {
        NeverReturns.pass("NsdManager.stopServiceDiscovery")
        synchronized(this) { assertTrue(searches.remove(listener), "listener not registered") }
    }

    @Implementation
    fun resolveService(service: NsdServiceInfo, listener: NsdManager.ResolveListener) {
        NeverReturns.pass("NsdManager.resolveService")
        resolve(service, listener)
    }

    private fun resolve(service: NsdServiceInfo, listener: NsdManager.ResolveListener) {
        synchronized(this) {
            assertNull(resolving, "FAILURE_ALREADY_ACTIVE")
            assertTrue(usedListeners.add(listener), "listener already in use")
            resolving = service.serviceName
        }
        val answer = { answer(service, listener) }
        if (isSlow) resolutions.trySendBlocking(answer) else answer()
    }

    private fun answer(service: NsdServiceInfo, listener: NsdManager.ResolveListener) {
        val whole = synchronized(this) {
            resolving = null
            usedListeners -= listener
            services[service.serviceName].takeUnless { service.serviceName in unresolvable }
        }
        if (whole == null) {
            listener.onResolveFailed(service, NsdManager.FAILURE_INTERNAL_ERROR)
        } else {
            listener.onServiceResolved(whole)
        }
    }

    private fun unresolved(name: String) = NsdServiceInfo().also { it.serviceName = name }

    companion object {
        /** Receives each one that Android constructs. */
        @Volatile
        var onConstructed: (FakeNsdManager) -> Unit = {}
    }
}

/** Counts the locks that are held, but not their finalization, which Robolectric's own takes for a release. */
@Implements(WifiManager.MulticastLock::class)
class FakeMulticastLock : ShadowWifiManager.ShadowMulticastLock() {
    private var isHeld = false

    @Implementation
    override fun acquire() {
        NeverReturns.pass("MulticastLock.acquire")
        if (!isHeld) held.incrementAndGet()
        isHeld = true
    }

    @Implementation
    override fun release() {
        NeverReturns.pass("MulticastLock.release")
        if (isHeld) held.decrementAndGet()
        isHeld = false
    }

    /** Called only before the release of a finalized lock. */
    @Implementation
    override fun setReferenceCounted(isCounted: Boolean) {
        isHeld = false
    }

    companion object {
        val held = AtomicInteger()
    }
}
