package dev.ml2sensors.session

import dev.ml2sensors.wire.ErrorCode
import dev.ml2sensors.wire.ProtocolException
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.CoroutineStart
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.async
import kotlinx.coroutines.cancel
import kotlinx.coroutines.launch
import kotlinx.coroutines.runBlocking
import org.junit.jupiter.api.AfterEach
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.time.Duration
import kotlin.time.Duration.Companion.minutes
import kotlin.time.Duration.Companion.seconds
import kotlin.time.TestTimeSource

class LinkTestTest {
    private val scope = CoroutineScope(Dispatchers.Default)
    private val time = TestTimeSource()
    private val kernel = FakeKernel()
    private var joins = 0
    private val test = LinkTest({ scope.launch { it() } }, time) { kernel.writer().also { joins++ } }

    @AfterEach
    fun close() = scope.cancel()

    @Test
    fun whatWasAskedForIsSentAndThenTheEnd() {
        kernel.open(4)
        test.begin(2 * WHOLE + 100)
        kernel.awaitWrites(4)
        assertEquals(listOf(WHOLE, WHOLE, 100, 0), kernel.lengths)
    }

    @Test
    fun aSlowLinkIsKeptBusyForTwoSecondsAtMost() {
        test.begin(64 shl 20)
        kernel.awaitEntered()
        time += 1.9.seconds
        kernel.open(1)
        kernel.awaitEntered()
        time += 0.1.seconds
        kernel.open(2)
        kernel.awaitWrites(3)
        assertEquals(listOf(WHOLE, WHOLE, 0), kernel.lengths)
    }

    @Test
    fun oneTestRunsAtATime() {
        test.begin(64 shl 20)
        kernel.awaitEntered()
        assertEquals(ErrorCode.UNEXPECTED, assertFailsWith<ProtocolException> { test.begin(1) }.code)
    }

    @Test
    fun anotherTestMayBeginOnTheSameLaneOnceTheEndIsRead() {
        for (tests in 1..20) {
            test.begin(1)
            kernel.open(2)
            kernel.awaitWrites(2 * tests)
        }
        assertEquals(1, joins)
    }

    @Test
    fun theEndOfTheSessionEndsATestBetweenTwoFrames() = runBlocking<Unit> {
        test.begin(64 shl 20)
        kernel.awaitEntered()
        val finishing = async(start = CoroutineStart.UNDISPATCHED) { test.finish(1.minutes) }
        kernel.open(2)
        finishing.await()
        assertEquals(listOf(WHOLE, 0), kernel.lengths)
        test.begin(1)
        kernel.open(2)
        test.finish(1.minutes)
        assertEquals(listOf(WHOLE, 0), kernel.lengths, "none begins any more")
    }

    @Test
    fun aTestWhoseReceiverDoesNotReadIsCutOff() = runBlocking<Unit> {
        test.begin(64 shl 20)
        kernel.awaitEntered()
        test.finish(Duration.ZERO)
        assertEquals(emptyList<Int>(), kernel.lengths)
    }

    private companion object {
        const val WHOLE = 64 * 1024
    }
}
