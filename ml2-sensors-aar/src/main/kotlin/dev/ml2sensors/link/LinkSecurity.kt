package dev.ml2sensors.link

/** How connections to receivers are protected. */
public sealed interface LinkSecurity {
    /** TLS 1.3 as the device [identity], and only with a receiver whose certificate is one of [receivers]. */
    public class Paired internal constructor(internal val client: TlsClient) : LinkSecurity {
        public constructor(identity: DeviceIdentity, receivers: Set<Fingerprint>) :
            this(TlsClient(identity, receivers))
    }

    /**
     * None: everybody on the network can read and change everything, and pretend to be the receiver.
     *
     * @property allowsEyeImages whether images of the wearer's eyes, which are biometric, are sent all the same.
     */
    public class Insecure(public val allowsEyeImages: Boolean = false) : LinkSecurity
}
