package dev.ml2sensors.stream

import dev.ml2sensors.message.CameraInfo
import dev.ml2sensors.message.CompressedImage
import dev.ml2sensors.message.CompressedVideo
import dev.ml2sensors.message.FfmpegPacket
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Image
import dev.ml2sensors.message.RegionOfInterest
import dev.ml2sensors.message.StringMessage
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.Intrinsics
import dev.ml2sensors.source.RosCamera
import dev.ml2sensors.source.isKeyFrame
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import kotlinx.serialization.json.Json
import java.nio.ByteBuffer

/** Returns the plane [pixels] of this sample as an image with [encoding] of image_encodings.hpp. */
internal fun ImageSample.toImage(
    header: Header,
    encoding: String,
    pixels: ByteBuffer,
): Image {
    // A compressed image has no rows; those of the planes beside it have no padding.
    val strideBytes = if (strideBytes == 0) pixels.remaining() / height else strideBytes
    return Image(
        header,
        height = height.toUInt(),
        width = width.toUInt(),
        encoding = encoding,
        isBigendian = 0u,
        step = strideBytes.toUInt(),
        data = rows(pixels, strideBytes, height),
    )
}

/**
 * Returns the rows of a plane for sensor_msgs/Image: whole rows of its stride, and nothing after the last. Copies only
 * if the last row needs padding.
 */
private fun rows(plane: ByteBuffer, strideBytes: Int, height: Int): ByteBuffer {
    val size = Math.multiplyExact(strideBytes, height)
    val rows = plane.duplicate().order(plane.order())
    if (plane.remaining() >= size) return rows.apply { limit(position() + size) }
    require(plane.remaining() > size - strideBytes) {
        "expected $height rows of $strideBytes bytes, the last one perhaps without padding, found ${plane.remaining()} bytes"
    }
    return ByteBuffer.allocate(size).apply {
        put(rows)
        rewind()
    }
}

/** Returns the compressed image of this sample; [format] as image_transport has it. */
internal fun ImageSample.toCompressedImage(
    header: Header,
    format: String,
): CompressedImage = CompressedImage(header, format, pixels)

/** Returns the image of this sample, which is an access unit of video; [encoding] as ffmpeg_image_transport has it. */
internal fun ImageSample.toFfmpegPacket(header: Header, encoding: String): FfmpegPacket =
    FfmpegPacket(
        header,
        width,
        height,
        encoding,
        pts = (captureNanos / NANOS_PER_MICRO).toULong(),
        flags = if (pixels.isKeyFrame()) 1u else 0u,
        isBigendian = false,
        data = pixels,
    )

/** Returns the image of this sample, which is an access unit of video; [format] as Foxglove has it. */
internal fun ImageSample.toCompressedVideo(header: Header, format: String): CompressedVideo =
    CompressedVideo(header.stamp, header.frameId, pixels, format)

private const val NANOS_PER_MICRO = 1000

/** Returns the camera's CameraInfo: R = identity, P = [K | 0], no binning, whole image. */
internal fun RosCamera.toCameraInfo(header: Header): CameraInfo =
    with(intrinsics) {
        CameraInfo(
            header,
            height = height.toUInt(),
            width = width.toUInt(),
            distortionModel = distortion.name,
            d = distortion.coefficients.toDoubleArray(),
            k = doubleArrayOf(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0),
            r = doubleArrayOf(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
            p = doubleArrayOf(fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0),
            binningX = 0u,
            binningY = 0u,
            roi = RegionOfInterest(0u, 0u, 0u, 0u, false),
        )
    }

/**
 * Returns the metadata of this capture as JSON with a stable schema, without the values that the device does not
 * report.
 *
 * @param codec `jpeg`, `rvl` or `h264` for an image that the headset compressed, null for one that is as the device delivers it.
 * @param quality of [codec], null if it has none.
 */
internal fun ImageSample.toMetadata(
    header: Header,
    camera: RosCamera?,
    codec: String? = null,
    quality: Int? = null,
): StringMessage {
    val isCompressed = strideBytes == 0
    val message =
        Metadata(
            Metadata.Stamp(header.stamp.sec, header.stamp.nanosec.toLong()),
            header.frameId,
            frameNumber,
            metadata.exposureNanos,
            metadata.analogGain,
            metadata.digitalGain,
            camera?.let { Metadata.DeviceIntrinsics.of(it.device) },
            camera?.maxResidualPx,
            metadata.illumination,
            metadata.stampSource,
            if (isCompressed) codec ?: JPEG else null,
            quality.takeIf { isCompressed },
            if (isCompressed) pixels.remaining() else null,
        )
    return StringMessage(metadataJson.encodeToString(Metadata.serializer(), message))
}

/** The codec of devices that deliver compressed images. */
private const val JPEG = "jpeg"

private val metadataJson = Json { explicitNulls = false }

/**
 * The schema of the metadata topics; lengths in pixels.
 *
 * @property intrinsics the device's own, also if CameraInfo cannot express their model.
 * @property encodedBytes the size of the compressed image.
 * @property cameraInfoMaxResidualPx the largest difference of CameraInfo to them in the image; absent if there is none.
 */
@Serializable
private class Metadata(
    val stamp: Stamp,
    @SerialName("frame_id") val frameId: String,
    @SerialName("frame_number") val frameNumber: Long,
    @SerialName("exposure_ns") val exposureNanos: Long?,
    @SerialName("analog_gain") val analogGain: Double?,
    @SerialName("digital_gain") val digitalGain: Double?,
    val intrinsics: DeviceIntrinsics?,
    @SerialName("camera_info_max_residual_px") val cameraInfoMaxResidualPx: Double?,
    val illumination: String?,
    @SerialName("stamp_source") val stampSource: String?,
    val codec: String?,
    val quality: Int?,
    @SerialName("encoded_bytes") val encodedBytes: Int?,
) {
    @Serializable
    class Stamp(
        val sec: Int,
        val nanosec: Long,
    )

    @Serializable
    class DeviceIntrinsics(
        val width: Int,
        val height: Int,
        @SerialName("focal_length") val focalLength: List<Double>,
        @SerialName("principal_point") val principalPoint: List<Double>,
        @SerialName("distortion_model") val distortionModel: String,
        @SerialName("distortion") val distortion: List<Double>,
    ) {
        companion object {
            fun of(it: Intrinsics): DeviceIntrinsics =
                DeviceIntrinsics(
                    it.width,
                    it.height,
                    listOf(it.fx, it.fy),
                    listOf(it.cx, it.cy),
                    it.distortion.name,
                    it.distortion.coefficients,
                )
        }
    }
}
