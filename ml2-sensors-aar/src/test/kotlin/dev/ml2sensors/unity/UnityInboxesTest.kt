package dev.ml2sensors.unity

import dev.ml2sensors.TEST_LIMIT
import dev.ml2sensors.capture.CaptureFixture
import dev.ml2sensors.capture.Native
import dev.ml2sensors.capture.Simulation
import dev.ml2sensors.ros.Keep
import dev.ml2sensors.ros.Received
import dev.ml2sensors.ros.SubscriptionException
import kotlinx.coroutines.CompletableDeferred
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.Job
import kotlinx.coroutines.NonCancellable
import kotlinx.coroutines.cancel
import kotlinx.coroutines.channels.Channel
import kotlinx.coroutines.delay
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.consumeAsFlow
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.runBlocking
import kotlinx.coroutines.test.runCurrent
import kotlinx.coroutines.test.runTest
import kotlinx.coroutines.withContext
import kotlinx.coroutines.withTimeout
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import kotlin.test.assertEquals
import kotlin.test.assertNull
import kotlin.time.Duration.Companion.milliseconds

/** Tests what a native reader finds in the inboxes of a Unity app. */
class UnityInboxesTest {
    private val fixture = CaptureFixture()
    private val scope = CoroutineScope(Dispatchers.Default + Job())
    private val inboxes = UnityInboxes(scope)
    private val mapped = Native.mappedBytes()

    @AfterEach
    fun close() {
        inboxes.close()
        scope.cancel()
        assertEquals(mapped, Native.mappedBytes())
        fixture.close()
    }

    /** A run whose only topic has what is sent. */
    private class Run : UnityInboxes.Topics {
        val messages = Channel<Received<ByteBuffer>>(Channel.UNLIMITED)
        val wanted = Channel<String>(Channel.UNLIMITED)

        override fun messages(
            topic: String,
            type: String,
            keep: Keep,
            maxHz: Double?,
            hash: String?,
        ): Flow<Received<ByteBuffer>> {
            wanted.trySend("$topic $type $keep $maxHz $hash")
            return messages.consumeAsFlow()
        }

        fun send(vararg bytes: Byte) {
            val behindOthers = ByteBuffer.wrap(byteArrayOf(99) + bytes + 99, 1, bytes.size).slice()
            messages.trySend(Received(behindOthers, publishedNanos = 1, number = 1))
        }
    }

    @Test
    fun messagesComeInTheirOrderOverStartsAndStops() = test {
        val inbox = inboxes.subscribe("/joints", "my_msgs/msg/Joints", "", 5, 0.0)
        for (number in 1..2) {
            val run = Run()
            inboxes.use(run)
            assertEquals("/joints my_msgs/msg/Joints All(depth=5) null null", run.wanted.receive())
            run.send(1, 2)
            run.send(3)
            assertEquals(listOf<Byte>(1, 2), taken(inbox))
            assertEquals(listOf<Byte>(3), taken(inbox))
        }
    }

    @Test
    fun aTopicIsSubscribedToWhileARunGoesOn() = test {
        val run = Run()
        inboxes.use(run)
        val inbox = inboxes.subscribe("/joints", "my_msgs/msg/Joints", "RIHS01_", 1, 2.5)
        assertEquals("/joints my_msgs/msg/Joints Latest 2.5 RIHS01_", run.wanted.receive())
        run.send(7)
        assertEquals(listOf<Byte>(7), taken(inbox))
        inboxes.unsubscribe(inbox)
        inboxes.unsubscribe(inbox)
        assertNull(Simulation.takeMessage(inbox))
    }

    @Test
    fun theReasonOfARefusalIsTheReceiversUntilTheNextStart() = test {
        val inbox = inboxes.subscribe("/joints", "my_msgs/msg/Joints", "", 1, 0.0)
        assertEquals("", inboxes.refusal(inbox))
        inboxes.use { _, _, _, _, _ -> flow { throw SubscriptionException.notServed("/joints") } }
        eventually { "serves no subscriptions" in inboxes.refusal(inbox) }
        inboxes.use { _, _, _, _, _ -> throw IllegalArgumentException("no name") }
        eventually { inboxes.refusal(inbox) == "no name" }
        inboxes.use(Run())
        eventually { inboxes.refusal(inbox) == "" }
    }

    @Test
    fun aRunThatEndsBeforeItsTurnLetsNoOtherComeBesideTheOneBefore() = runTest {
        val inboxes = UnityInboxes(backgroundScope)
        inboxes.subscribe("/joints", "my_msgs/msg/Joints", "", 1, 0.0)
        val isOver = CompletableDeferred<Unit>()
        var begun = 0
        val run = UnityInboxes.Topics { _, _, _, _, _ ->
            begun++
            flow { withContext(NonCancellable) { isOver.await() } }
        }
        inboxes.use(run)
        runCurrent()
        repeat(2) { inboxes.use(run) }
        runCurrent()
        assertEquals(1, begun)
        isOver.complete(Unit)
        runCurrent()
        assertEquals(2, begun)
        inboxes.close()
    }

    private fun test(block: suspend () -> Unit) = runBlocking { withTimeout(TEST_LIMIT) { block() } }

    private suspend fun taken(inbox: Int): List<Byte> {
        var message: ByteArray? = null
        eventually { Simulation.takeMessage(inbox).also { message = it } != null }
        return message.orEmpty()
    }

    private fun ByteArray?.orEmpty(): List<Byte> = this?.toList().orEmpty()

    private suspend fun eventually(isSo: () -> Boolean) {
        while (!isSo()) delay(1.milliseconds)
    }
}
