package dev.ml2sensors.pairing

import java.io.IOException

/** Pairing failed: the code is wrong, used or expired, or `ml2-receiver pair` no longer runs. */
public class PairingException internal constructor(message: String, cause: Throwable? = null) :
    IOException(message, cause)
