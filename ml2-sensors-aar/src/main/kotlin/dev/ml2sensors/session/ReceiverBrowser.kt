package dev.ml2sensors.session

import kotlinx.coroutines.flow.Flow

/** Looks for receivers on the local networks: DNS-SD over mDNS, in the platform's way. */
public fun interface ReceiverBrowser {
    /**
     * The receivers there are, by name, whenever that changes, with the fingerprints they announce. Every collection
     * looks anew, and looks no longer when it ends. Fails with an [java.io.IOException] where looking is impossible.
     */
    public fun receivers(): Flow<Map<String, ReceiverAddress>>

    public companion object {
        /** The type of the service, without a domain. */
        public const val SERVICE_TYPE: String = "_ml2sensors._tcp"

        /** The key of the TXT record whose value is the fingerprint of the receiver's certificate. */
        public const val FINGERPRINT_KEY: String = "fp"
    }
}
