package dev.ml2sensors.simulator

import org.conscrypt.Conscrypt
import java.security.Security

/**
 * Makes Android's TLS that of this process, where Conscrypt runs. The JVM's own enciphers in the interpreter for its
 * first seconds, which is too slow for all sensors at once.
 */
internal fun useAndroidTls() {
    if (Conscrypt.isAvailable()) Security.insertProviderAt(Conscrypt.newProvider(), 1)
}
