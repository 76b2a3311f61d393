package dev.ml2sensors.transport

import java.io.IOException

/** Why there is no protected connection to a receiver. */
public sealed class TransportException(message: String, cause: Throwable? = null) : IOException(message, cause)

/**
 * Another machine answers at [receiver], or the receiver has another key.
 *
 * @property expected those that this device is paired with.
 * @property found that of the certificate that was shown.
 */
public class WrongReceiverException internal constructor(
    receiver: String,
    public val expected: Set<Fingerprint>,
    public val found: Fingerprint,
) : TransportException(
    "the receiver at $receiver is not the one this headset is paired with " +
        "(expected fingerprint ${expected.joinToString(" or ")}, found $found); pair again",
)

/** This device knows no receiver, or the receiver does not, or no longer, know this device's certificate. */
public class NotPairedException internal constructor(with: String, cause: Throwable? = null) :
    TransportException("this headset is not paired with $with; run ml2-receiver pair", cause)

/** The receiver does not encrypt. */
public class PlaintextReceiverException internal constructor(receiver: String) :
    TransportException(
        "the receiver at $receiver does not encrypt: it was started with --insecure, or is no receiver of this version",
    )

/** There is no common way to encrypt, or the encryption is broken. */
public class TlsException internal constructor(receiver: String, found: String, cause: Throwable? = null) :
    TransportException("expected TLS 1.3 with the receiver at $receiver, found: $found", cause)
