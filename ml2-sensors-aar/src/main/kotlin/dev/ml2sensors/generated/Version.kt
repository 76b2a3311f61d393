package dev.ml2sensors

/** The version of this library, from the root POM. */
public object Version {
    public const val NAME: String = "0.1.0"
}
