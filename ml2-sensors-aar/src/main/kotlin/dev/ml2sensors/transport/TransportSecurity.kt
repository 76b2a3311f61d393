package dev.ml2sensors.transport

import java.io.IOException

/** How connections to receivers are protected. */
public sealed interface TransportSecurity {
    /**
     * TLS 1.3 as one device, and only with the receivers it is paired with.
     *
     * @param makeClient is called by the first connection, on its thread; when it fails with an [IOException], so does
     * the connection, and the next calls it again.
     */
    public class Paired internal constructor(makeClient: () -> TlsClient) : TransportSecurity {
        /** As the device [identity], with a receiver whose certificate is one of [receivers]. */
        public constructor(identity: DeviceIdentity, receivers: Set<Fingerprint>) :
            this({ TlsClient(identity, receivers) })

        internal val client: TlsClient by lazy(makeClient)
    }

    /**
     * None: everybody on the network can read and change everything, and pretend to be the receiver.
     *
     * @property allowsEyeImages whether images of the wearer's eyes, which are biometric, are sent all the same.
     */
    public class Insecure(public val allowsEyeImages: Boolean = false) : TransportSecurity
}
