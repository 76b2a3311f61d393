package dev.ml2sensors.source

/** The thermal state of a headset by Android's grades, coolest first; [wireName] as in PROTOCOL.md, STATUS. */
public enum class Thermal {
    /** Not throttled. */
    NONE,

    /** Throttled, which users do not notice. */
    LIGHT,

    /** Throttled, which users may notice. */
    MODERATE,

    /** Throttled, which impairs use. */
    SEVERE,

    /** Throttled as far as the platform can. */
    CRITICAL,

    /** The device shuts down parts of itself. */
    EMERGENCY,

    /** The device must shut down at once. */
    SHUTDOWN,
    ;

    /** The name in lower case. */
    public val wireName: String get() = name.lowercase()
}
