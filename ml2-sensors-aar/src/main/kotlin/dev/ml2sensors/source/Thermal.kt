package dev.ml2sensors.source

/** How hot a headset is, as Android grades it, coolest first; [wireName] as in PROTOCOL.md, STATUS. */
public enum class Thermal {
    /** No throttling. */
    NONE,

    /** Throttled without being noticed. */
    LIGHT,

    /** Throttled noticeably. */
    MODERATE,

    /** Throttled so that use suffers. */
    SEVERE,

    /** The platform has done what it can to cool down. */
    CRITICAL,

    /** Parts of the device are being shut down. */
    EMERGENCY,

    /** It has to be shut down at once. */
    SHUTDOWN,
    ;

    /** Lower case. */
    public val wireName: String get() = name.lowercase()
}
