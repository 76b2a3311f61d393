package dev.ml2sensors.table

/** The streams of config/streams.yaml; generated from it by config/generate.py. */
public object StreamTable {
    /** The REP-103 frame that poses are in. */
    public const val WORLD_FRAME: String = "magicleap_world"

    /** The body frame of the headset. */
    public const val HEAD_FRAME: String = "head_frame"

    /** The lane of the class `sensors`. */
    internal val sensorsLane: LaneClass =
        LaneClass(name = "sensors", isShared = true, isPaced = false, queueFrames = 16384, maxPayloadBytes = 65536)

    /** The lanes of the class `image`. */
    internal val imageLane: LaneClass =
        LaneClass(name = "image", isShared = false, isPaced = true, queueFrames = 4, maxPayloadBytes = 16777216)

    /** The lanes of the class `bulk`. */
    internal val bulkLane: LaneClass =
        LaneClass(name = "bulk", isShared = false, isPaced = true, queueFrames = 4, maxPayloadBytes = 16777216)

    /** sensor_msgs/msg/Image on world_center/image_raw. */
    public val worldCenter: StreamSpec =
        StreamSpec(
            id = "world_center",
            section = "world_center",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "world_center/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "world_center",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_center/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "world_center",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_center/image_raw/ffmpeg",
                    type = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
                    lane = "world_center",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264;yuv420p;mono8;mono8",
                    condition = "format=h264",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_center/image_raw/foxglove",
                    type = "foxglove_msgs/msg/CompressedVideo",
                    lane = "world_center",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264",
                    condition = "format=h264_foxglove",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "world_center/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "world_center/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "world_center_optical_frame",
            bodyFrameId = "world_center_frame",
            encoding = "mono8",
            permissions = listOf("android.permission.CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1016 to 1016),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("Grayscale", "jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1016 to 1016),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on world_left/image_raw. */
    public val worldLeft: StreamSpec =
        StreamSpec(
            id = "world_left",
            section = "world_left",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "world_left/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "world_left",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_left/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "world_left",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_left/image_raw/ffmpeg",
                    type = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
                    lane = "world_left",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264;yuv420p;mono8;mono8",
                    condition = "format=h264",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_left/image_raw/foxglove",
                    type = "foxglove_msgs/msg/CompressedVideo",
                    lane = "world_left",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264",
                    condition = "format=h264_foxglove",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "world_left/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "world_left/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "world_left_optical_frame",
            bodyFrameId = "world_left_frame",
            encoding = "mono8",
            permissions = listOf("android.permission.CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1016 to 1016),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("Grayscale", "jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1016 to 1016),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on world_right/image_raw. */
    public val worldRight: StreamSpec =
        StreamSpec(
            id = "world_right",
            section = "world_right",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "world_right/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "world_right",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_right/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "world_right",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_right/image_raw/ffmpeg",
                    type = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
                    lane = "world_right",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264;yuv420p;mono8;mono8",
                    condition = "format=h264",
                ),
                TopicSpec(
                    role = "image",
                    name = "world_right/image_raw/foxglove",
                    type = "foxglove_msgs/msg/CompressedVideo",
                    lane = "world_right",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264",
                    condition = "format=h264_foxglove",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "world_right/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "world_right/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "world_right_optical_frame",
            bodyFrameId = "world_right_frame",
            encoding = "mono8",
            permissions = listOf("android.permission.CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1016 to 1016),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("Grayscale", "jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1016 to 1016),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/CompressedImage on color/image_raw/compressed. */
    public val color: StreamSpec =
        StreamSpec(
            id = "color",
            section = "picture_center",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "color/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "color",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "image",
                    name = "color/image_raw/ffmpeg",
                    type = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
                    lane = "color",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264;yuv420p;bgr8;bgr8",
                    condition = "format=h264",
                ),
                TopicSpec(
                    role = "image",
                    name = "color/image_raw/foxglove",
                    type = "foxglove_msgs/msg/CompressedVideo",
                    lane = "color",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264",
                    condition = "format=h264_foxglove",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "color/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "color/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "color_optical_frame",
            bodyFrameId = "color_frame",
            encoding = "rgb8; jpeg compressed bgr8",
            permissions = listOf("android.permission.CAMERA"),
            backends = listOf("camera2", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(15, 30, 60),
                    resolutions = listOf(640 to 480, 1280 to 720, 1280 to 960, 1440 to 1080, 1920 to 1080, 2048 to 1536),
                ),
                Mode(
                    stream = 0,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(15, 30),
                    resolutions = listOf(2880 to 2160, 3840 to 2160, 4096 to 3072),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30, 60),
                    resolutions = listOf(648 to 720, 972 to 1080, 960 to 720, 1440 to 1080),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1944 to 2160, 2880 to 2160),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/CompressedImage on mixed_reality/image_raw/compressed. */
    public val mixedReality: StreamSpec =
        StreamSpec(
            id = "mixed_reality",
            section = "picture_center",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "mixed_reality/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "mixed_reality",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "image",
                    name = "mixed_reality/image_raw/ffmpeg",
                    type = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
                    lane = "mixed_reality",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264;yuv420p;bgr8;bgr8",
                    condition = "format=h264",
                ),
                TopicSpec(
                    role = "image",
                    name = "mixed_reality/image_raw/foxglove",
                    type = "foxglove_msgs/msg/CompressedVideo",
                    lane = "mixed_reality",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "h264",
                    condition = "format=h264_foxglove",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "mixed_reality/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "mixed_reality/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "color_optical_frame",
            bodyFrameId = "color_frame",
            encoding = "rgb8; jpeg compressed bgr8",
            permissions = listOf("android.permission.CAMERA"),
            backends = listOf("camera2", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(15, 30, 60),
                    resolutions = listOf(640 to 480, 1280 to 720, 1280 to 960, 1440 to 1080, 1920 to 1080, 2048 to 1536),
                ),
                Mode(
                    stream = 0,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(15, 30),
                    resolutions = listOf(2880 to 2160, 3840 to 2160, 4096 to 3072),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30, 60),
                    resolutions = listOf(648 to 720, 972 to 1080, 960 to 720, 1440 to 1080),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("jpeg", "h264", "h264_foxglove"),
                    rates = listOf(30),
                    resolutions = listOf(1944 to 2160, 2880 to 2160),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on depth/image_raw. */
    public val depth: StreamSpec =
        StreamSpec(
            id = "depth",
            section = "depth_center",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "depth/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "depth",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Depth32",
                ),
                TopicSpec(
                    role = "image",
                    name = "depth/image_raw/compressedDepth",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "depth",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "16UC1; compressedDepth rvl",
                    condition = "format=depth16",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "depth/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "depth/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "confidence",
                    name = "depth/confidence",
                    type = "sensor_msgs/msg/Image",
                    lane = "depth",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "confidence=true",
                ),
                TopicSpec(
                    role = "flags",
                    name = "depth/flags",
                    type = "sensor_msgs/msg/Image",
                    lane = "depth",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "32SC1",
                    condition = "flags=true",
                ),
            ),
            frameId = "depth_optical_frame",
            bodyFrameId = "depth_frame",
            encoding = "32FC1",
            permissions = listOf("com.magicleap.permission.DEPTH_CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Depth32", "depth16", "DepthRaw"),
                    rates = listOf(1, 5),
                    resolutions = listOf(544 to 480),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("Depth32", "depth16", "DepthRaw"),
                    rates = listOf(5, 25, 30, 50, 60),
                    resolutions = listOf(544 to 480),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on infra/image_raw. */
    public val infra: StreamSpec =
        StreamSpec(
            id = "infra",
            section = "depth_center",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "infra/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "infra",
                    laneClass = imageLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "camera_info",
                    name = "infra/camera_info",
                    type = "sensor_msgs/msg/CameraInfo",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "infra/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "depth_optical_frame",
            bodyFrameId = "depth_frame",
            encoding = "32FC1",
            permissions = listOf("com.magicleap.permission.DEPTH_CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Depth32", "depth16", "DepthRaw"),
                    rates = listOf(1, 5),
                    resolutions = listOf(544 to 480),
                ),
                Mode(
                    stream = 1,
                    formats = listOf("Depth32", "depth16", "DepthRaw"),
                    rates = listOf(5, 25, 30, 50, 60),
                    resolutions = listOf(544 to 480),
                ),
            ),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on eye_nasal_left/image_raw. */
    public val eyeNasalLeft: StreamSpec =
        StreamSpec(
            id = "eye_nasal_left",
            section = "eye_nasal_left",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "eye_nasal_left/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "eye_nasal_left",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "eye_nasal_left/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "eye_nasal_left",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "eye_nasal_left/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "eye_nasal_left_optical_frame",
            encoding = "mono8",
            permissions = listOf("com.magicleap.permission.EYE_CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg"),
                    rates = listOf(30),
                    resolutions = listOf(400 to 400),
                ),
            ),
            showsEyes = true,
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on eye_nasal_right/image_raw. */
    public val eyeNasalRight: StreamSpec =
        StreamSpec(
            id = "eye_nasal_right",
            section = "eye_nasal_right",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "eye_nasal_right/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "eye_nasal_right",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "eye_nasal_right/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "eye_nasal_right",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "eye_nasal_right/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "eye_nasal_right_optical_frame",
            encoding = "mono8",
            permissions = listOf("com.magicleap.permission.EYE_CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg"),
                    rates = listOf(30),
                    resolutions = listOf(400 to 400),
                ),
            ),
            showsEyes = true,
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on eye_temple_left/image_raw. */
    public val eyeTempleLeft: StreamSpec =
        StreamSpec(
            id = "eye_temple_left",
            section = "eye_temple_left",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "eye_temple_left/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "eye_temple_left",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "eye_temple_left/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "eye_temple_left",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "eye_temple_left/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "eye_temple_left_optical_frame",
            encoding = "mono8",
            permissions = listOf("com.magicleap.permission.EYE_CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg"),
                    rates = listOf(30),
                    resolutions = listOf(400 to 400),
                ),
            ),
            showsEyes = true,
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Image on eye_temple_right/image_raw. */
    public val eyeTempleRight: StreamSpec =
        StreamSpec(
            id = "eye_temple_right",
            section = "eye_temple_right",
            topics = listOf(
                TopicSpec(
                    role = "image",
                    name = "eye_temple_right/image_raw",
                    type = "sensor_msgs/msg/Image",
                    lane = "eye_temple_right",
                    laneClass = imageLane,
                    qos = "image",
                    condition = "format=Grayscale",
                ),
                TopicSpec(
                    role = "image",
                    name = "eye_temple_right/image_raw/compressed",
                    type = "sensor_msgs/msg/CompressedImage",
                    lane = "eye_temple_right",
                    laneClass = imageLane,
                    qos = "image",
                    encoding = "mono8; jpeg compressed mono8",
                    condition = "format=jpeg",
                ),
                TopicSpec(
                    role = "metadata",
                    name = "eye_temple_right/metadata",
                    type = "std_msgs/msg/String",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "image",
                ),
            ),
            frameId = "eye_temple_right_optical_frame",
            encoding = "mono8",
            permissions = listOf("com.magicleap.permission.EYE_CAMERA"),
            backends = listOf("sdk", "openxr"),
            modes = listOf(
                Mode(
                    stream = 0,
                    formats = listOf("Grayscale", "jpeg"),
                    rates = listOf(30),
                    resolutions = listOf(400 to 400),
                ),
            ),
            showsEyes = true,
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/Imu on accel_left/imu. */
    public val accelLeft: StreamSpec =
        StreamSpec(
            id = "accel_left",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "accel_left/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_left_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on accel_right/imu. */
    public val accelRight: StreamSpec =
        StreamSpec(
            id = "accel_right",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "accel_right/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_right_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on accel_compute_pack/imu. */
    public val accelComputePack: StreamSpec =
        StreamSpec(
            id = "accel_compute_pack",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "accel_compute_pack/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_compute_pack_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on gyro_left/imu. */
    public val gyroLeft: StreamSpec =
        StreamSpec(
            id = "gyro_left",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "gyro_left/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_left_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on gyro_right/imu. */
    public val gyroRight: StreamSpec =
        StreamSpec(
            id = "gyro_right",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "gyro_right/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_right_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on gyro_compute_pack/imu. */
    public val gyroComputePack: StreamSpec =
        StreamSpec(
            id = "gyro_compute_pack",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "gyro_compute_pack/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_compute_pack_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on imu_left/imu. */
    public val imuLeft: StreamSpec =
        StreamSpec(
            id = "imu_left",
            section = "imu",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "imu_left/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_left_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on imu_right/imu. */
    public val imuRight: StreamSpec =
        StreamSpec(
            id = "imu_right",
            section = "imu",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "imu_right/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_right_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Imu on imu_compute_pack/imu. */
    public val imuComputePack: StreamSpec =
        StreamSpec(
            id = "imu_compute_pack",
            section = "imu",
            topics = listOf(
                TopicSpec(
                    role = "imu",
                    name = "imu_compute_pack/imu",
                    type = "sensor_msgs/msg/Imu",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "imu",
                ),
            ),
            frameId = "imu_compute_pack_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Illuminance on light_sensor. */
    public val lightSensor: StreamSpec =
        StreamSpec(
            id = "light_sensor",
            section = "other_sensors",
            topics = listOf(
                TopicSpec(
                    role = "illuminance",
                    name = "light_sensor",
                    type = "sensor_msgs/msg/Illuminance",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "head_frame",
            backends = listOf("sensor_manager"),
        )

    /** geometry_msgs/msg/PoseStamped on head_pose. */
    public val headPose: StreamSpec =
        StreamSpec(
            id = "head_pose",
            section = "head_pose",
            topics = listOf(
                TopicSpec(
                    role = "pose",
                    name = "head_pose",
                    type = "geometry_msgs/msg/PoseStamped",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_world",
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/MagneticField on magnetometer_left. */
    public val magnetometerLeft: StreamSpec =
        StreamSpec(
            id = "magnetometer_left",
            section = "magnetometer",
            topics = listOf(
                TopicSpec(
                    role = "magnetic_field",
                    name = "magnetometer_left",
                    type = "sensor_msgs/msg/MagneticField",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "imu_left_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/MagneticField on magnetometer_right. */
    public val magnetometerRight: StreamSpec =
        StreamSpec(
            id = "magnetometer_right",
            section = "magnetometer",
            topics = listOf(
                TopicSpec(
                    role = "magnetic_field",
                    name = "magnetometer_right",
                    type = "sensor_msgs/msg/MagneticField",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "imu_right_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/FluidPressure on pressure_headset. */
    public val pressureHeadset: StreamSpec =
        StreamSpec(
            id = "pressure_headset",
            section = "pressure",
            topics = listOf(
                TopicSpec(
                    role = "pressure",
                    name = "pressure_headset",
                    type = "sensor_msgs/msg/FluidPressure",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "head_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 4,
        )

    /** sensor_msgs/msg/FluidPressure on pressure_compute_pack. */
    public val pressureComputePack: StreamSpec =
        StreamSpec(
            id = "pressure_compute_pack",
            section = "pressure",
            topics = listOf(
                TopicSpec(
                    role = "pressure",
                    name = "pressure_compute_pack",
                    type = "sensor_msgs/msg/FluidPressure",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "imu_compute_pack_frame",
            backends = listOf("sensor_manager"),
            longestPauseSeconds = 4,
        )

    /** geometry_msgs/msg/PoseStamped on gaze. */
    public val gaze: StreamSpec =
        StreamSpec(
            id = "gaze",
            section = "gaze",
            topics = listOf(
                TopicSpec(
                    role = "pose",
                    name = "gaze",
                    type = "geometry_msgs/msg/PoseStamped",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_world",
            permissions = listOf("com.magicleap.permission.EYE_TRACKING"),
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** geometry_msgs/msg/PoseArray on hand_left. */
    public val handLeft: StreamSpec =
        StreamSpec(
            id = "hand_left",
            section = "hands",
            topics = listOf(
                TopicSpec(
                    role = "poses",
                    name = "hand_left",
                    type = "geometry_msgs/msg/PoseArray",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_world",
            permissions = listOf("com.magicleap.permission.HAND_TRACKING"),
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** geometry_msgs/msg/PoseArray on hand_right. */
    public val handRight: StreamSpec =
        StreamSpec(
            id = "hand_right",
            section = "hands",
            topics = listOf(
                TopicSpec(
                    role = "poses",
                    name = "hand_right",
                    type = "geometry_msgs/msg/PoseArray",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_world",
            permissions = listOf("com.magicleap.permission.HAND_TRACKING"),
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/BatteryState on battery. */
    public val battery: StreamSpec =
        StreamSpec(
            id = "battery",
            section = "battery",
            topics = listOf(
                TopicSpec(
                    role = "battery",
                    name = "battery",
                    type = "sensor_msgs/msg/BatteryState",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "head_frame",
            backends = listOf("battery_manager"),
            longestPauseSeconds = 600,
        )

    /** tf2_msgs/msg/TFMessage on /tf. */
    public val tf: StreamSpec =
        StreamSpec(
            id = "tf",
            section = "tf",
            topics = listOf(
                TopicSpec(
                    role = "tf",
                    name = "/tf",
                    type = "tf2_msgs/msg/TFMessage",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "tf",
                ),
                TopicSpec(
                    role = "tf_static",
                    name = "/tf_static",
                    type = "tf2_msgs/msg/TFMessage",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "latched",
                    condition = "layout=rig",
                ),
            ),
            frameId = "magicleap_world",
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** Topics and services of the app on the headset, below the names of its own. */
    public val custom: StreamSpec =
        StreamSpec(id = "custom", section = "custom", frameId = "", backends = listOf("app"))

    /** geometry_msgs/msg/PoseStamped on controller. */
    public val controller: StreamSpec =
        StreamSpec(
            id = "controller",
            section = "controller",
            topics = listOf(
                TopicSpec(
                    role = "pose",
                    name = "controller",
                    type = "geometry_msgs/msg/PoseStamped",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_world",
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** sensor_msgs/msg/Joy on controller/joy. */
    public val controllerJoy: StreamSpec =
        StreamSpec(
            id = "controller_joy",
            section = "controller",
            topics = listOf(
                TopicSpec(
                    role = "joy",
                    name = "controller/joy",
                    type = "sensor_msgs/msg/Joy",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "controller_frame",
            backends = listOf("sdk", "openxr"),
            longestPauseSeconds = 2,
        )

    /** vision_msgs/msg/Detection3DArray on markers. */
    public val markers: StreamSpec =
        StreamSpec(
            id = "markers",
            section = "markers",
            topics = listOf(
                TopicSpec(
                    role = "detections",
                    name = "markers",
                    type = "vision_msgs/msg/Detection3DArray",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_world",
            permissions = listOf("com.magicleap.permission.MARKER_TRACKING"),
            backends = listOf("openxr"),
            longestPauseSeconds = 2,
        )

    /** diagnostic_msgs/msg/DiagnosticArray on map/state. */
    public val map: StreamSpec =
        StreamSpec(
            id = "map",
            section = "map",
            topics = listOf(
                TopicSpec(
                    role = "map_state",
                    name = "map/state",
                    type = "diagnostic_msgs/msg/DiagnosticArray",
                    lane = "sensors",
                    laneClass = sensorsLane,
                    qos = "sensor",
                ),
            ),
            frameId = "magicleap_map",
            permissions = listOf("com.magicleap.permission.SPACE_MANAGER"),
            backends = listOf("openxr"),
            longestPauseSeconds = 4,
        )

    /** The order in which images give way to the link. */
    internal val adaptation: AdaptationSpec =
        AdaptationSpec(
            streams = listOf(
                listOf("eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right"),
                listOf("color", "mixed_reality"),
                listOf("depth", "infra"),
                listOf("world_center"),
                listOf("world_left", "world_right"),
            ),
            qualities = listOf(60, 40),
            ratesHz = listOf(25, 20, 15, 10, 7, 5, 3, 1),
            firstRoundHz = listOf(5, 5, 5, 5, 10),
        )

    /** The size of a JPEG by its quality, relative to that at quality 80. */
    internal val jpegSizes: Map<Int, Double> =
        mapOf(1 to 0.15, 20 to 0.33, 40 to 0.5, 60 to 0.65, 80 to 1.0, 90 to 1.6, 100 to 5.0)

    /** The rules for topics of [custom]. */
    internal val customTopics: CustomTopicsSpec =
        CustomTopicsSpec(
            role = "custom",
            small = sensorsLane,
            large = bulkLane,
            qos = "sensor",
            latchedQos = "latched",
            maxTopics = 32,
        )

    /** All streams, in the order of the file. */
    public val all: List<StreamSpec> =
        listOf(
            worldCenter,
            worldLeft,
            worldRight,
            color,
            mixedReality,
            depth,
            infra,
            eyeNasalLeft,
            eyeNasalRight,
            eyeTempleLeft,
            eyeTempleRight,
            accelLeft,
            accelRight,
            accelComputePack,
            gyroLeft,
            gyroRight,
            gyroComputePack,
            imuLeft,
            imuRight,
            imuComputePack,
            lightSensor,
            headPose,
            magnetometerLeft,
            magnetometerRight,
            pressureHeadset,
            pressureComputePack,
            gaze,
            handLeft,
            handRight,
            battery,
            tf,
            custom,
            controller,
            controllerJoy,
            markers,
            map,
        )

    /** Returns the stream with this [id], or null if there is none. */
    public fun byId(id: String): StreamSpec? = all.firstOrNull { it.id == id }
}
