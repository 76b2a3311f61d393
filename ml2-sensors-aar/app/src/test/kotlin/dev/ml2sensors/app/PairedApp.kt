package dev.ml2sensors.app

import android.content.pm.PackageManager
import dev.ml2sensors.android.FakeKeystore
import dev.ml2sensors.session.HostSession
import dev.ml2sensors.session.ScriptedHost
import dev.ml2sensors.transport.TestIdentity
import dev.ml2sensors.transport.TlsPeer
import kotlinx.coroutines.runBlocking
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import java.io.File
import java.security.Security

/** The app on a headset that is paired with a scripted receiver and connects to it by address, over real TLS. */
internal class PairedApp : AutoCloseable {
    val app = RuntimeEnvironment.getApplication() as App
    val host = ScriptedHost(server = TlsPeer.serverSocket(TlsPeer.trusting(TestIdentity.device)))
    private val keystore = FakeKeystore().apply { add("dev.ml2sensors.device", TestIdentity.device) }

    init {
        Security.addProvider(keystore)
        shadowOf(app.packageManager).setSystemFeature(PackageManager.FEATURE_WIFI, true)
        val receiver = """{"name": "desk", "fingerprint": "${TestIdentity.receiver.fingerprint}",
            "host": "${host.address.host}", "port": ${host.address.port}}"""
        File(app.filesDir, "ml2-sensors-receivers.json").writeText("""{"receivers": [$receiver]}""")
        app.settings.receiver = "${host.address}"
    }

    /** Waits for the app to connect, and starts a session in which the receiver requests [streams]. */
    fun session(streams: String, ros: Boolean = false): HostSession {
        val session = host.awaitHello()
        session.welcome(host.received(), ros = ros)
        session.configure(1, streams)
        session.start(1)
        return session
    }

    override fun close() {
        runBlocking { app.streaming.stop() }
        Security.removeProvider(keystore.name)
        host.close()
    }
}
