package dev.ml2sensors.session

import kotlinx.coroutines.flow.Flow

/** Finds receivers on the local networks: DNS-SD over mDNS, implemented by the platform. */
public fun interface ReceiverBrowser {
    /**
     * Emits the present receivers by name, with the fingerprints that they announce, whenever they change. Each
     * collection starts a search and ends it. Fails with a [java.io.IOException] if searching is impossible.
     */
    public fun receivers(): Flow<Map<String, ReceiverAddress>>

    public companion object {
        /** The type of the service, without a domain. */
        public const val SERVICE_TYPE: String = "_ml2sensors._tcp"

        /** The key of the TXT record whose value is the fingerprint of the receiver's certificate. */
        public const val FINGERPRINT_KEY: String = "fp"
    }
}
