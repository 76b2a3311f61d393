package dev.ml2sensors.simulator

import org.conscrypt.Conscrypt
import java.security.Security

/**
 * Installs Conscrypt, Android's TLS, as the TLS of this process if Conscrypt runs here. The JVM's own TLS encrypts in
 * the interpreter for its first seconds, which is too slow for all sensors at once. Conscrypt needs 0.25 s of a
 * processor to start, as it checks the signature of its native library.
 */
internal fun useAndroidTls() {
    if (Conscrypt.isAvailable()) Security.insertProviderAt(Conscrypt.newProvider(), 1)
}
