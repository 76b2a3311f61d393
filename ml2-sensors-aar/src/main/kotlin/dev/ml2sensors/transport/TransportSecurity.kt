package dev.ml2sensors.transport

import java.io.IOException

/** The protection of connections to receivers. */
public sealed interface TransportSecurity {
    /**
     * TLS 1.3 as one device, only with the receivers that it is paired with.
     *
     * @param makeClient is called by the first connection, on its thread. If it fails with an [IOException], so does
     * the connection, and the next one calls it again.
     */
    public class Paired internal constructor(makeClient: () -> TlsClient) : TransportSecurity {
        /** Connects as the device [identity] to receivers whose certificate is one of [receivers]. */
        internal constructor(identity: DeviceIdentity, receivers: Set<Fingerprint>) :
            this({ TlsClient(identity, receivers) })

        // Without a lock, which would be held while the platform's key store is awaited
        internal val client: TlsClient by lazy(LazyThreadSafetyMode.PUBLICATION, makeClient)
    }

    /**
     * No protection: everybody on the network can read and change all data, and impersonate the receiver.
     *
     * @property allowsEyeImages true to send images of the wearer's eyes, which are biometric, all the same.
     */
    public class Insecure(public val allowsEyeImages: Boolean = false) : TransportSecurity
}
