package dev.ml2sensors.unity

import android.Manifest
import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.session.HostFrame
import dev.ml2sensors.session.Receiver
import dev.ml2sensors.session.ScriptedHost
import dev.ml2sensors.transport.TransportSecurity
import dev.ml2sensors.unity.UnityProbe.Companion.state
import dev.ml2sensors.unity.UnityProbe.Companion.streams
import dev.ml2sensors.unity.UnityProbe.Companion.text
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import kotlinx.serialization.json.Json
import kotlinx.serialization.json.jsonArray
import kotlinx.serialization.json.jsonObject
import kotlinx.serialization.json.jsonPrimitive
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.RuntimeEnvironment
import org.robolectric.Shadows.shadowOf
import org.robolectric.annotation.Config
import java.util.concurrent.CountDownLatch
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotEquals
import kotlin.test.assertTrue
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TimeSource

/** Tests the calls of C# with a headset that has a battery and nothing else, and a scripted receiver. */
@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], manifest = Config.NONE)
class Ml2UnityTest {
    private val app = RuntimeEnvironment.getApplication()
    private val host = ScriptedHost()
    private val probe = UnityProbe()
    private val unity = probe.unity

    @After
    fun close() {
        probe.close()
        host.close()
    }

    @Test
    fun theStatusFollowsTheSession() {
        assertEquals("ended" to "not started", probe.status().state to probe.status().text("reason"))
        start("")
        val session = session("""{"battery": {}, "world_left": {}}""")
        val connected = probe.await { it.state == "connected" && "battery" in it.streams }
        assertEquals("scripted", connected.text("receiver"))
        assertEquals("running", connected.streams.getValue("battery").jsonObject.text("state"))
        val refused = connected.streams.getValue("world_left").jsonObject
        assertEquals("refused", refused.text("state"))
        assertTrue(refused.text("reason").isNotEmpty())
        val counts = probe.status().getValue("channels").jsonObject.getValue("battery").jsonObject
        assertEquals(setOf("produced", "sent", "dropped"), counts.keys)
        assertTrue(probe.status().getValue("clock").jsonObject.text("state").isNotEmpty())
        unity.stop()
        assertNotEquals("not started", probe.status().text("reason"), "while the session ends")
        assertEquals("""{"reason":"stopped"}""", session.await(HostFrame.BYE).body.decodeToString())
        probe.await { it.state == "ended" }
        assertEquals("stopped", probe.status().text("reason"))
    }

    @Test
    fun aRunThatEndsByItselfIsTold() = runBlocking {
        val failing = object : Receiver {
            override suspend fun locate() = throw UnsatisfiedLinkError("no library")
        }
        Ml2Sensors.open(app).use { headset ->
            val run =
                UnityRun(headset, failing, TransportSecurity.Insecure(), UnityRun.Request("", emptyMap(), true))
            val told = mutableListOf<Pair<String, String>>()
            run.run { told += run.status().let { it.state to it.reason } }
            assertEquals("ended" to "failed: UnsatisfiedLinkError: no library", told.last())
        }
    }

    @Test
    fun anotherStartEndsTheSessionBefore() {
        repeat(2) {
            start("{}")
            session("{}")
            probe.await { it.state == "connected" }
        }
    }

    /** A session whose receiver does not close its side takes a second to end. */
    @Test
    fun aStartWaitsForTheEndOfAllSessionsBefore() {
        host.closesAfterBye = false
        start("{}")
        session("{}")
        val ending = TimeSource.Monotonic.markNow()
        ScriptedHost().use { unity.start(it.address.toString(), "{}", insecure = true) }
        start("{}")
        host.awaitHello()
        assertTrue(ending.elapsedNow() >= 1.seconds, "the next session began after ${ending.elapsedNow()}")
    }

    @Test
    fun closingEndsTheSessionThoughNoThreadIsFree() {
        start("{}")
        val session = session("{}")
        val threads = maxOf(2, Runtime.getRuntime().availableProcessors())
        val isBusy = CountDownLatch(threads)
        val isFree = CountDownLatch(1)
        repeat(threads) {
            CoroutineScope(Dispatchers.Default).launch {
                isBusy.countDown()
                isFree.await()
            }
        }
        isBusy.await()
        unity.close()
        Thread.getAllStackTraces().keys.filter { it.name == "ml2s close" }.forEach(Thread::join)
        isFree.countDown()
        assertEquals("""{"reason":"stopped"}""", session.await(HostFrame.BYE).body.decodeToString())
    }

    @Test
    fun whatIsNoReceiverAndNoJsonIsMisuse() {
        for (receiver in listOf("host:", "host:0", "host:65536", "http://host:80", "host:1/x", "ml2s://host:1")) {
            assertFailsWith<IllegalArgumentException>(receiver) { unity.start(receiver, "{}", insecure = true) }
        }
        assertFailsWith<IllegalArgumentException> { unity.start("", "no JSON", insecure = true) }
    }

    @Test
    fun withoutAReceiverTheDefaultsRunUntilOneSaysWhatItWants() {
        start("""{"battery": {}}""")
        host.awaitHello().close()
        val alone = probe.await { "battery" in it.streams }
        assertEquals("connecting", alone.state)
        session("""{"pressure_headset": {}}""")
        probe.await { it.streams.keys == setOf("pressure_headset") }
    }

    @Test
    fun missingPermissionsAreToldWithTheStreamsTheyAreFor() {
        start("""{"world_left": {}, "world_right": {}, "battery": {}}""")
        // On a machine that stands still for a moment, Android does not answer in time
        val limit = TimeSource.Monotonic.markNow() + TEST_LIMIT
        val answers = generateSequence { unity.permissionsNeeded().takeIf { limit.hasNotPassedNow() } }
        val row = Json.parseToJsonElement(answers.first { it != "[]" }).jsonArray.single().jsonObject
        assertEquals(Manifest.permission.CAMERA, row.text("permission"))
        assertEquals(
            listOf("world_left", "world_right"),
            row.getValue("streams").jsonArray.map {
                it.jsonPrimitive.content
            },
        )
        assertTrue(row.text("reason").isNotEmpty())
        shadowOf(app).grantPermissions(Manifest.permission.CAMERA)
        assertEquals("[]", unity.permissionsNeeded())
    }

    @Test
    fun viewsAndTopicsNeedTheNativeLibrary() {
        assertFailsWith<IllegalStateException> { unity.view("world_left", true) }
        assertFailsWith<IllegalArgumentException> { unity.view("no_stream", true) }
        assertFailsWith<IllegalStateException> { unity.inboxes().subscribe("/joints", JOINTS, "", 1, 0.0) }
        val publishers = unity.publishers()
        assertFailsWith<IllegalStateException> { publishers.open("note", JOINTS, false, false, false, 1) }
    }

    @Test
    fun whatIsClosedStartsNoMore() {
        unity.close()
        unity.close()
        assertFailsWith<IllegalStateException> { start("{}") }
    }

    private fun session(streams: String) = host.session(streams)

    private fun start(defaults: String) = unity.start(host.address.toString(), defaults, insecure = true)

    private companion object {
        const val JOINTS = "sensor_msgs/msg/JointState"
    }
}
