package dev.ml2sensors.transport

import java.io.IOException

/** There is no protected connection to a receiver. */
public sealed class TransportException(message: String, cause: Throwable? = null) : IOException(message, cause)

/**
 * Another machine answers at the receiver's address, or the receiver has another key.
 *
 * @property expected the fingerprints that this device is paired with.
 * @property found the fingerprint of the certificate that was shown.
 */
public class WrongReceiverException internal constructor(
    receiver: String,
    public val expected: Set<Fingerprint>,
    public val found: Fingerprint,
) : TransportException(
    "the receiver at $receiver is not the one this headset is paired with " +
        "(expected fingerprint ${expected.joinToString(" or ")}, found $found); pair again",
)

/** This device is not paired with any receiver, or the receiver does not accept its certificate. */
public class NotPairedException internal constructor(with: String, cause: Throwable? = null) :
    TransportException("this headset is not paired with $with; run ml2-receiver pair", cause)

/** The receiver does not encrypt. */
internal class PlaintextReceiverException internal constructor(receiver: String) :
    TransportException(
        "the receiver at $receiver does not encrypt: it was started with --insecure, or is no receiver of this version",
    )

/** There is no common TLS version, or the encryption is broken. */
internal class TlsException internal constructor(receiver: String, found: String, cause: Throwable? = null) :
    TransportException("expected TLS 1.3 with the receiver at $receiver, found: $found", cause)
