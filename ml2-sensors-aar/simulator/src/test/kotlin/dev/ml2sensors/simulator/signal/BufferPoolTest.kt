package dev.ml2sensors.simulator.signal

import org.junit.jupiter.api.Test
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.concurrent.ConcurrentHashMap
import kotlin.concurrent.thread
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertSame
import kotlin.test.assertTrue

class BufferPoolTest {
    @Test
    fun buffersAreLentUntilNoneIsFree() {
        val pool = BufferPool(bufferBytes = 8, count = 2)
        val lent = List(2) { assertNotNull(pool.acquire()) }
        assertNull(pool.acquire())
        assertEquals(2, pool.outstanding)
        pool.release(lent[1])
        assertSame(lent[1], pool.acquire())
    }

    @Test
    fun buffersAreDirectLittleEndianAndCleared() {
        val pool = BufferPool(bufferBytes = 8, count = 1)
        repeat(2) {
            val buffer = assertNotNull(pool.acquire())
            assertTrue(buffer.isDirect)
            assertEquals(ByteOrder.LITTLE_ENDIAN, buffer.order())
            assertEquals(0 to 8, buffer.position() to buffer.limit())
            buffer.putInt(1).flip()
            pool.release(buffer)
        }
    }

    @Test
    fun aBufferGivenBackTwiceIsMisuseEvenWhileOthersAreInUse() {
        val pool = BufferPool(bufferBytes = 8, count = 3)
        val lent = List(3) { assertNotNull(pool.acquire()) }
        pool.release(lent[0])
        assertFailsWith<IllegalStateException> { pool.release(lent[0]) }
        assertEquals(2, pool.outstanding)
    }

    @Test
    fun aBufferOfAnotherPoolIsMisuse() {
        val pool = BufferPool(bufferBytes = 8, count = 1)
        pool.acquire()
        assertFailsWith<IllegalStateException> { pool.release(ByteBuffer.allocateDirect(8)) }
        assertNull(pool.acquire())
    }

    @Test
    fun takingWaitsForABufferThatIsGivenBack() {
        val pool = BufferPool(bufferBytes = 8, count = 1)
        val lent = pool.acquireBlocking()
        val giver = thread { pool.release(lent) }
        assertSame(lent, pool.acquireBlocking())
        giver.join()
        assertEquals(1, pool.outstanding)
    }

    @Test
    fun noBufferIsLentToTwoThreadsAtOnce() {
        val pool = BufferPool(bufferBytes = 8, count = 3)
        val inUse = ConcurrentHashMap.newKeySet<Int>()
        val users = List(4) {
            thread {
                repeat(5_000) {
                    val buffer = pool.acquireBlocking()
                    check(inUse.add(System.identityHashCode(buffer)))
                    inUse.remove(System.identityHashCode(buffer))
                    pool.release(buffer)
                }
            }
        }
        users.forEach(Thread::join)
        assertEquals(0, pool.outstanding, "a user that failed keeps its buffer")
    }
}
