package dev.ml2sensors.simulator

import java.security.Security
import javax.net.ssl.SSLContext
import kotlin.test.AfterTest
import kotlin.test.Test
import kotlin.test.assertEquals

class AndroidTlsTest {
    @AfterTest
    fun removeProvider(): Unit = Security.removeProvider("Conscrypt")

    @Test
    fun tlsComesFromConscrypt() {
        useAndroidTls()
        assertEquals("Conscrypt", SSLContext.getInstance("TLSv1.3").provider.name)
    }
}
