package dev.ml2sensors

/** The version of this library; generated from pom.xml by config/generate.py. */
public object Version {
    /** MAJOR.MINOR.PATCH. */
    public const val NAME: String = "0.1.0"
}
