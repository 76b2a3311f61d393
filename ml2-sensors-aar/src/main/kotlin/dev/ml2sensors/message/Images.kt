package dev.ml2sensors.message

import dev.ml2sensors.cdr.ByteSequenceSerializer
import dev.ml2sensors.cdr.FixedLength
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import java.nio.ByteBuffer

/**
 * An uncompressed image, rows from the top, pixels from the left. Source: sensor_msgs/msg/Image, Jazzy.
 *
 * @property header Capture time, and the optical frame of the camera: z forward, x right, y down.
 * @property height Number of rows.
 * @property width Pixels per row.
 * @property encoding `mono8`, `32FC1` or another name of sensor_msgs/image_encodings.hpp.
 * @property isBigendian 1 if numbers of more than one byte are big-endian, else 0.
 * @property step Bytes from one row to the next.
 * @property data [step] times [height] bytes between position and limit, owned by whoever made the message.
 */
@Serializable
@SerialName("sensor_msgs/msg/Image")
public class Image(
    public val header: Header,
    public val height: UInt,
    public val width: UInt,
    public val encoding: String,
    public val isBigendian: UByte,
    public val step: UInt,
    @Serializable(ByteSequenceSerializer::class)
    public val data: ByteBuffer,
)

/**
 * A compressed image. Source: sensor_msgs/msg/CompressedImage, Jazzy.
 *
 * @property header As in [Image].
 * @property format As image_transport has it, such as `rgb8; jpeg compressed bgr8`.
 * @property data The file's bytes between position and limit, owned by whoever made the message.
 */
@Serializable
@SerialName("sensor_msgs/msg/CompressedImage")
internal class CompressedImage(
    val header: Header,
    val format: String,
    @Serializable(ByteSequenceSerializer::class)
    val data: ByteBuffer,
)

/**
 * One image of a video. Source: ffmpeg_image_transport_msgs/msg/FFMPEGPacket, Jazzy.
 *
 * @property header As in [Image].
 * @property width Pixels per row.
 * @property height Number of rows.
 * @property encoding The codec, the pixel format of the video, and the encoding of the decoded image, twice, such as
 * `h264;yuv420p;mono8;mono8`.
 * @property pts Time of presentation; a number that no other packet of the stream has.
 * @property flags 1 for a key frame, else 0.
 * @property isBigendian True if numbers of more than one byte are big-endian.
 * @property data The access unit's bytes between position and limit, owned by whoever made the message.
 */
@Serializable
@SerialName("ffmpeg_image_transport_msgs/msg/FFMPEGPacket")
internal class FfmpegPacket(
    val header: Header,
    val width: Int,
    val height: Int,
    val encoding: String,
    val pts: ULong,
    val flags: UByte,
    val isBigendian: Boolean,
    @Serializable(ByteSequenceSerializer::class)
    val data: ByteBuffer,
)

/**
 * One image of a video. Source: foxglove_msgs/msg/CompressedVideo.
 *
 * @property timestamp Capture time.
 * @property frameId The optical frame of the camera, as in [Image].
 * @property data The access unit's bytes between position and limit, owned by whoever made the message.
 * @property format `h264`: a byte stream (Annex B).
 */
@Serializable
@SerialName("foxglove_msgs/msg/CompressedVideo")
internal class CompressedVideo(
    val timestamp: Time,
    val frameId: String,
    @Serializable(ByteSequenceSerializer::class)
    val data: ByteBuffer,
    val format: String,
)

/**
 * Intrinsic calibration of a camera, in pixels of the full resolution. Source: sensor_msgs/msg/CameraInfo, Jazzy.
 *
 * @property header Stamp and frame of the image it belongs to.
 * @property height Rows the camera was calibrated with.
 * @property width Pixels per row the camera was calibrated with.
 * @property distortionModel `plumb_bob` or `equidistant`.
 * @property d Distortion: k1, k2, p1, p2, k3 for `plumb_bob`; k1 to k4 for `equidistant`.
 * @property k Intrinsic matrix fx 0 cx, 0 fy cy, 0 0 1 of the distorted image; 3x3, row-major.
 * @property r Rectifying rotation; 3x3, row-major.
 * @property p Projection matrix of the rectified image; 3x4, row-major.
 * @property binningX Pixels combined into one horizontally; 0 means 1.
 * @property binningY Pixels combined into one vertically; 0 means 1.
 * @property roi The part of the full resolution that the image shows; all zeros means all of it.
 */
@Serializable
@SerialName("sensor_msgs/msg/CameraInfo")
internal class CameraInfo(
    val header: Header,
    val height: UInt,
    val width: UInt,
    val distortionModel: String,
    val d: DoubleArray,
    @FixedLength(9) val k: DoubleArray,
    @FixedLength(9) val r: DoubleArray,
    @FixedLength(12) val p: DoubleArray,
    val binningX: UInt,
    val binningY: UInt,
    val roi: RegionOfInterest,
)

/**
 * Part of an image, in pixels of its full resolution. Source: sensor_msgs/msg/RegionOfInterest, Jazzy.
 *
 * @property xOffset Leftmost pixel.
 * @property yOffset Topmost row.
 * @property height Number of rows; 0 means all.
 * @property width Pixels per row; 0 means all.
 * @property doRectify True if the part is to be rectified on its own.
 */
@Serializable
@SerialName("sensor_msgs/msg/RegionOfInterest")
internal data class RegionOfInterest(
    val xOffset: UInt,
    val yOffset: UInt,
    val height: UInt,
    val width: UInt,
    val doRectify: Boolean,
)
