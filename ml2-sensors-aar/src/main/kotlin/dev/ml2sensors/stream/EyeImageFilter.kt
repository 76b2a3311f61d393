package dev.ml2sensors.stream

import dev.ml2sensors.source.Answer
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.StreamValues
import dev.ml2sensors.table.StreamSpec
import dev.ml2sensors.transport.TransportSecurity

/** Returns this headset without eye images, unless [security] protects or allows them. */
internal fun Headset.withoutUnprotectedEyeImages(security: TransportSecurity): Headset =
    if (security is TransportSecurity.Insecure && !security.allowsEyeImages) EyeImageFilter(this) else this

private class EyeImageFilter(private val headset: Headset) : Headset by headset {
    override fun negotiate(stream: StreamSpec, requested: StreamValues): Answer =
        if (stream.showsEyes) Answer.Refused(REFUSAL) else headset.negotiate(stream, requested)

    private companion object {
        const val REFUSAL = "eye images are biometric: pair, or allow with --insecure-eye-images"
    }
}
