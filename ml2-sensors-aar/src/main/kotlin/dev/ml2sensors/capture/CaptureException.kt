package dev.ml2sensors.capture

import dev.ml2sensors.source.SourceException

/** A sensor of the device cannot be used, or no longer. The message names what is missing or what failed. */
internal sealed class CaptureException(message: String) : SourceException(message) {
    /** A library or symbol is missing, or the device has no such sensor. */
    class NotAvailable internal constructor(message: String) : CaptureException(message)

    /** The app has not, or no longer, the Android permission that the sensor needs. */
    class PermissionDenied @JvmOverloads internal constructor(
        message: String,
        override val permission: String? = null,
    ) : CaptureException(message)

    /** Another use in this process excludes this one. */
    class InUse internal constructor(message: String) : CaptureException(message)

    /** A call of the vendor's API failed. */
    class VendorFailure internal constructor(message: String) : CaptureException(message)
}
