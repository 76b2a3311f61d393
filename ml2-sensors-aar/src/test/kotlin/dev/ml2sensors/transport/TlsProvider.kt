package dev.ml2sensors.transport

import org.conscrypt.Conscrypt
import java.security.Provider

/** The TLS that the device uses; Conscrypt is Android's. */
enum class TlsProvider(val newInstance: () -> Provider?) {
    JVM({ null }),
    CONSCRYPT({ Conscrypt.newProvider() }),
}
