package dev.ml2sensors.source

import dev.ml2sensors.message.Transform

/** An image of [planes]; whatever a test leaves out does not matter to it. */
internal fun testImage(
    width: Int,
    height: Int,
    planes: List<ImageSample.Plane> = emptyList(),
    captureNanos: Long = 5,
    frameNumber: Long = 6,
    strideBytes: Int = width,
    pose: Transform? = null,
    intrinsics: Intrinsics? = null,
    metadata: CaptureMetadata = CaptureMetadata(exposureNanos = 7),
    giveBack: () -> Unit = {},
) = ImageSample(
    captureNanos,
    frameNumber,
    width,
    height,
    strideBytes,
    pose,
    intrinsics,
    metadata,
    planes,
    giveBack,
)
