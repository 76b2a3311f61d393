package dev.ml2sensors.session

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.wire.Closed
import dev.ml2sensors.wire.Frame
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.Opened
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.cancel
import kotlinx.coroutines.flow.first
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeout
import java.io.Closeable
import java.net.InetAddress
import java.net.ServerSocket
import kotlin.time.Duration

/** Opens all of [wanted] in each session, and ignores what comes. */
internal class ListedOpenings(private vararg val wanted: Open) : AppOpenings {
    override suspend fun serve(lanes: OpeningLanes?) = wanted.forEach { lanes?.open(it) }

    override fun opened(answer: Opened) = Unit

    override fun closed(end: Closed) = Unit

    override fun take(frame: Frame, left: () -> Unit) = true
}

/** Sessions of [FakeStreams] with a [ScriptedHost]. */
internal class SessionFixture(drainLimit: Duration = TEST_LIMIT, server: ServerSocket = ServerSocket()) : Closeable {
    val host = ScriptedHost(server = server)
    val streams = FakeStreams(drainLimit)
    val stop = CompletableDeferred<String>()
    val clock = HostClock(System::nanoTime)
    private val scope = CoroutineScope(Dispatchers.Default)

    /** Runs a session; its outcome is why it failed, null when it ended in order. */
    fun run(
        receiver: ReceiverAddress = host.address,
        security: TransportSecurity = TransportSecurity.Insecure(),
        app: AppOpenings? = null,
        resolve: (String) -> List<InetAddress> = ::addressesOf,
    ): Deferred<Throwable?> {
        val session = Session(receiver, security, DeviceClock(System::nanoTime), clock, streams, resolve, app)
        val capabilities = Hello.Capabilities(streams.capabilities, ros = app != null)
        val hello = Hello(listOf(1), "device", "instance", "Größe", "test", capabilities, mapOf("camera" to true))
        return scope.async {
            runCatching { session.run(hello, stop) { streams.call("welcome $it") } }.exceptionOrNull()
        }
    }

    /** A session that is welcomed and has START for [streams]; nothing of the lane [held] is read yet. */
    fun started(vararg streams: String, held: String? = null): HostSession {
        val session = host.awaitHello()
        held?.let(session::hold)
        session.welcome(host.received())
        session.configure(1, streams.joinToString(prefix = "{", postfix = "}") { "\"$it\": {}" })
        session.start(1)
        await("start")
        return session
    }

    /** Waits until the session has called [call]. */
    fun await(call: String) = runBlocking { withTimeout(TEST_LIMIT) { streams.calls.first { call in it } } }

    fun outcome(session: Deferred<Throwable?>): Throwable? = runBlocking { withTimeout(TEST_LIMIT) { session.await() } }

    fun offer(topic: String, payloadBytes: Int = 8) = runBlocking { streams.offer(topic, payloadBytes) }

    override fun close() {
        scope.cancel()
        host.close()
    }
}
