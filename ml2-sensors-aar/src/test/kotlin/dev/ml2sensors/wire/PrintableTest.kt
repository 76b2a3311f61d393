package dev.ml2sensors.wire

import org.junit.jupiter.api.Test
import kotlin.random.Random
import kotlin.test.assertEquals
import kotlin.test.assertFalse
import kotlin.test.assertNotNull
import kotlin.test.assertNull
import kotlin.test.assertTrue

class PrintableTest {
    @Test
    fun whatMovesACursorOrHidesIsEscaped() {
        assertEquals("a\\u001b]52;c;eA==\\u0007b", printable("a\u001b]52;c;eA==\u0007b"))
        assertEquals("\\u202etxt.\\u000a\\u2028", printable("\u202etxt.\n\u2028"))
        assertEquals("\\ud800", printable("\ud800"))
        assertEquals("Größe \uD83E\uDD7D é", printable("Größe \uD83E\uDD7D é"))
    }

    @Test
    fun longTextIsCut() {
        assertEquals("x".repeat(512), printable("x".repeat(512)))
        assertEquals("x".repeat(509) + "...", printable("x".repeat(100_000)))
        assertEquals("\\u0007...", printable("\u0007".repeat(9), most = 9))
    }

    @Test
    fun nothingThatCanBeSentComesThroughUnescaped() {
        val random = Random(20261127)
        repeat(2000) {
            val text = String(CharArray(random.nextInt(1, 700)) { random.nextInt(0x10000).toChar() })
            val clean = printable(text)
            assertTrue(clean.length <= 512)
            assertFalse(clean.any { it.isISOControl() || it.category.code in setOf("Cf", "Zl", "Zp", "Co") }, clean)
        }
    }

    @Test
    fun namesAreShortAndPrintable() {
        assertNull(violation("Größe \uD83E\uDD7D", "receiver 1"))
        assertNull(violation("\uD83E\uDD7D".repeat(64)))
        for (name in listOf("", "x".repeat(65), "a\nb", "\u200b")) assertNotNull(violation(name), name)
        assertNotNull(violation("desk", "x".repeat(129)))
    }
}
