package dev.ml2sensors.pairing

import java.io.IOException

/** The receiver did not pair: the code is wrong, used or too old, or `ml2-receiver pair` is over. */
public class PairingException internal constructor(message: String, cause: Throwable? = null) :
    IOException(message, cause)
