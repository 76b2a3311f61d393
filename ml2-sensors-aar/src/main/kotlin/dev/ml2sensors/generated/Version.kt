package dev.ml2sensors

/** Of this library; generated from pom.xml by config/generate.py. */
public const val VERSION: String = "0.1.0"
