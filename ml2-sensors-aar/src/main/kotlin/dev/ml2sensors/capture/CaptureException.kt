package dev.ml2sensors.capture

import dev.ml2sensors.source.SourceException

/** Why a sensor of the device cannot be used, or no longer; the message names what was missing or what failed. */
public sealed class CaptureException(message: String) : SourceException(message) {
    /** A library or symbol is missing, or the device has no such sensor. */
    public class NotAvailable internal constructor(message: String) : CaptureException(message)

    /** The app has not, or no longer, the Android permission that the sensor needs. */
    public class PermissionDenied @JvmOverloads internal constructor(
        message: String,
        override val permission: String? = null,
    ) : CaptureException(message)

    /** Somebody in this process uses the sensor in a way that excludes this one. */
    public class InUse internal constructor(message: String) : CaptureException(message)

    /** A call of the vendor's failed. */
    public class VendorFailure internal constructor(message: String) : CaptureException(message)
}
