package dev.ml2sensors.session

import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertFailsWith

class ReceiverAddressTest {
    @Test
    fun addressesAreHostAndPort() {
        assertEquals("192.168.1.5:7447", ReceiverAddress("192.168.1.5", 7447).toString())
        assertEquals("[fe80::1]:7447", ReceiverAddress("fe80::1", 7447).toString())
    }

    @Test
    fun otherAddressesAreMisuse() {
        for (port in listOf(-1, 0, 65536)) assertFailsWith<IllegalArgumentException> { ReceiverAddress("host", port) }
        assertFailsWith<IllegalArgumentException> { ReceiverAddress("", 1) }
    }
}
