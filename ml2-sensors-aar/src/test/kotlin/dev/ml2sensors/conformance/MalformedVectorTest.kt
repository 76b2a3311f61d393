package dev.ml2sensors.conformance

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.clock.HostClock
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.ListedOpenings
import dev.ml2sensors.session.ReceiverAddress
import dev.ml2sensors.session.Session
import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.BatterySample
import dev.ml2sensors.source.ChargeStatus
import dev.ml2sensors.source.DeviceClock
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.Sample
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.stream.ActiveStreams
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.wire.Hello
import dev.ml2sensors.wire.Open
import dev.ml2sensors.wire.ProtocolException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Deferred
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.awaitCancellation
import kotlinx.coroutines.cancel
import kotlinx.coroutines.cancelAndJoin
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.withTimeout
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.decodeFromJsonElement
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.jupiter.api.AfterAll
import org.junit.jupiter.api.DynamicTest
import org.junit.jupiter.api.DynamicTest.dynamicTest
import org.junit.jupiter.api.TestFactory
import org.junit.jupiter.api.TestInstance
import java.io.IOException
import java.util.concurrent.Callable
import java.util.concurrent.Executors
import kotlin.test.assertEquals
import kotlin.test.assertIs
import kotlin.time.Duration.Companion.milliseconds

/**
 * Runs the device's side of tests/conformance/vectors/malformed. Several app instances share the vectors, and each
 * outlives all of its own; most of a vector's time is spent waiting for the peer or for a limit of the protocol.
 */
@TestInstance(TestInstance.Lifecycle.PER_CLASS)
class MalformedVectorTest {
    private val scope = CoroutineScope(Dispatchers.Default)
    private val threads = Executors.newFixedThreadPool(APPS)
    private val apps = ThreadLocal.withInitial { App(scope) }

    @AfterAll
    fun close() {
        threads.shutdownNow()
        scope.cancel()
    }

    @TestFactory
    fun faultyReceiversAreRefusedAndGoodOnesServed(): List<DynamicTest> = Vector
        .loadAll("malformed")
        .filter { it.text("side") == "device" }
        .map { vector ->
            val outcome = threads.submit(Callable { runCatching { apps.get().check(vector) } })
            dynamicTest(vector.name) { outcome.get().getOrThrow() }
        }

    private companion object {
        const val APPS = 6
    }
}

private val OPENINGS = VectorHost.OPENINGS.map { Json.decodeFromJsonElement<Open>(it) }.toTypedArray()

/** One instance of an app, which serves one session at a time. */
private class App(private val scope: CoroutineScope) {
    private val headset = BatteryHeadset()
    private val hostClock = HostClock(headset.clock)
    private val streams = ActiveStreams(headset, hostClock, scope)

    fun check(vector: Vector) {
        for (sent in vector.attempts()) {
            withSession(vector.hasOpenings) { host, session -> checkAttempt(host, session, vector, sent) }
        }
        withSession(ros = false) { host, _ ->
            host.reach("streaming", "control")
            checkLife(host)
        }
    }

    /** Runs [check] while a session connects to the host, and ends both; lanes belong to one session at a time. */
    private fun withSession(ros: Boolean, check: (VectorHost, Deferred<Throwable?>) -> Unit) {
        VectorHost().use { host ->
            val session = startSession(host, ros)
            try {
                check(host, session)
            } finally {
                host.close()
                runBlocking { session.cancelAndJoin() }
            }
        }
    }

    private fun checkAttempt(host: VectorHost, session: Deferred<Throwable?>, vector: Vector, sent: ByteArray) {
        val lane = vector.text("lane")
        host.reach(vector.text("given"), lane, vector.hasOpenings)
        host.answersTime = lane != "time"
        host.play(lane, sent)
        if (sent.size < vector.bytes.size) host.shutdownOutput(lane)
        val expect = vector.case.getValue("expect").jsonObject
        val code = expect["error"]?.jsonPrimitive?.content
        when {
            code != null -> {
                val error = host.await(HostFrame.ERROR).json
                assertEquals(code, error.getValue("code").jsonPrimitive.content, error.toString())
                host.close() // as a receiver does that is told
                val failure = assertIs<ProtocolException>(failureOf(session))
                assertEquals(code, failure.code.wireName, failure.toString())
            }

            "closed" in expect -> {
                assertIs<IOException>(failureOf(session))
                host.await(HostFrame.END)
            }

            "failure" in expect -> {
                val failure = host.await(HostFrame.FAILURE).json.getValue("code")
                assertEquals(expect.getValue("failure"), failure)
                checkIsRead(host, lane)
            }

            lane == "control" -> checkLife(host)

            else -> checkIsRead(host, lane)
        }
    }

    private fun checkLife(host: VectorHost) {
        host.play("control", HostFrame.bytes(HostFrame.PING))
        host.await(HostFrame.PONG)
        host.await(HostFrame.DATA)
    }

    /** Checks that the device has passed the skipped frame: it judges the next one. */
    private fun checkIsRead(host: VectorHost, lane: String) {
        host.play(lane, HostFrame.bytes(HostFrame.PING))
        assertEquals("unexpected", host.await(HostFrame.ERROR).json.getValue("code").jsonPrimitive.content)
    }

    private fun startSession(host: VectorHost, ros: Boolean): Deferred<Throwable?> {
        val session =
            Session(
                ReceiverAddress("127.0.0.1", host.port),
                TransportSecurity.Insecure(),
                headset.clock,
                hostClock,
                streams,
                app = if (ros) ListedOpenings(*OPENINGS) else null,
            )
        val capabilities = Hello.Capabilities(streams.capabilities, ros)
        val hello = Hello(listOf(1), "device", "instance", "Conformance", "conformance", capabilities, emptyMap())
        return scope.async { runCatching { session.run(hello, CompletableDeferred()) {} }.exceptionOrNull() }
    }

    private fun failureOf(session: Deferred<Throwable?>): Throwable? =
        runBlocking { withTimeout(TEST_LIMIT) { session.await() } }
}

private fun Vector.text(key: String): String = case.getValue(key).jsonPrimitive.content

private val Vector.hasOpenings get() = "ros" in case || text("given").startsWith("open")

private fun Vector.attempts(): List<ByteArray> =
    if ("cut" in case) (1 until bytes.size).map { bytes.copyOf(it) } else listOf(bytes)

/** Has a battery that reports and a world camera that sees nothing. */
private class BatteryHeadset : Headset {
    override val identity = Headset.Identity("device", "Conformance")
    override val clock = DeviceClock(System::nanoTime)
    override val timeline = Headset.Timeline.LIVE

    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer = when (stream) {
        StreamTable.battery, StreamTable.worldLeft -> Answer.Applied(requested)
        else -> Answer.Refused("not on this headset")
    }

    override fun samples(stream: StreamSpec, values: StreamValues): Flow<Sample> = flow {
        if (stream != StreamTable.battery) awaitCancellation()
        while (true) {
            emit(BatterySample(clock.nowNanos(), 4f, 1f, 0.5f, ChargeStatus.DISCHARGING))
            delay(5.milliseconds)
        }
    }

    override fun close() = Unit
}
