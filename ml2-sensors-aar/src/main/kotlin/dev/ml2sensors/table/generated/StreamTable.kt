package dev.ml2sensors.table

/** The streams of config/streams.yaml; generated from it by config/generate.py. */
public object StreamTable {
    /** The REP-103 frame that poses are in. */
    public const val WORLD_FRAME: String = "magicleap_world"

    /** The body frame of the headset. */
    public const val HEAD_FRAME: String = "head_frame"

    /** Everything that is small. */
    internal val sensorsLane: QueueSpec = QueueSpec(4096)

    /** One per image stream. */
    internal val imageLane: QueueSpec = QueueSpec(4)

    /** sensor_msgs/msg/Image on world_center/image_raw. */
    public val worldCenter: StreamSpec =
        StreamSpec(
            "world_center",
            "world_center",
            listOf(
                TopicSpec(
                    "image",
                    "world_center/image_raw",
                    "sensor_msgs/msg/Image",
                    "world_center",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "camera_info",
                    "world_center/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "world_center/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "world_center_optical_frame",
            "world_center_frame",
            "mono8",
            listOf("android.permission.CAMERA"),
            listOf("sdk", "openxr"),
            listOf(
                Mode(0, listOf("Grayscale"), listOf(30), listOf(1016 to 1016), mapOf()),
                Mode(1, listOf("Grayscale"), listOf(30), listOf(1016 to 1016), mapOf()),
            ),
        )

    /** sensor_msgs/msg/Image on world_left/image_raw. */
    public val worldLeft: StreamSpec =
        StreamSpec(
            "world_left",
            "world_left",
            listOf(
                TopicSpec("image", "world_left/image_raw", "sensor_msgs/msg/Image", "world_left", "image", null, null),
                TopicSpec(
                    "camera_info",
                    "world_left/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "world_left/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "world_left_optical_frame",
            "world_left_frame",
            "mono8",
            listOf("android.permission.CAMERA"),
            listOf("sdk", "openxr"),
            listOf(
                Mode(0, listOf("Grayscale"), listOf(30), listOf(1016 to 1016), mapOf()),
                Mode(1, listOf("Grayscale"), listOf(30), listOf(1016 to 1016), mapOf()),
            ),
        )

    /** sensor_msgs/msg/Image on world_right/image_raw. */
    public val worldRight: StreamSpec =
        StreamSpec(
            "world_right",
            "world_right",
            listOf(
                TopicSpec(
                    "image",
                    "world_right/image_raw",
                    "sensor_msgs/msg/Image",
                    "world_right",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "camera_info",
                    "world_right/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "world_right/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "world_right_optical_frame",
            "world_right_frame",
            "mono8",
            listOf("android.permission.CAMERA"),
            listOf("sdk", "openxr"),
            listOf(
                Mode(0, listOf("Grayscale"), listOf(30), listOf(1016 to 1016), mapOf()),
                Mode(1, listOf("Grayscale"), listOf(30), listOf(1016 to 1016), mapOf()),
            ),
        )

    /** sensor_msgs/msg/CompressedImage on color/image_raw/compressed. */
    public val color: StreamSpec =
        StreamSpec(
            "color",
            "picture_center",
            listOf(
                TopicSpec(
                    "image",
                    "color/image_raw/compressed",
                    "sensor_msgs/msg/CompressedImage",
                    "color",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "camera_info",
                    "color/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "color/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "color_optical_frame",
            "color_frame",
            "rgb8; jpeg compressed bgr8",
            listOf("android.permission.CAMERA"),
            listOf("camera2", "openxr"),
            listOf(
                Mode(
                    0,
                    listOf("jpeg"),
                    listOf(15, 30, 60),
                    listOf(640 to 480, 1280 to 720, 1280 to 960, 1440 to 1080, 1920 to 1080, 2048 to 1536),
                    mapOf(),
                ),
                Mode(0, listOf("jpeg"), listOf(15, 30), listOf(2880 to 2160, 3840 to 2160, 4096 to 3072), mapOf()),
                Mode(
                    1,
                    listOf("jpeg"),
                    listOf(30, 60),
                    listOf(648 to 720, 972 to 1080, 960 to 720, 1440 to 1080),
                    mapOf(),
                ),
                Mode(1, listOf("jpeg"), listOf(30), listOf(1944 to 2160, 2880 to 2160), mapOf()),
            ),
        )

    /** sensor_msgs/msg/CompressedImage on mixed_reality/image_raw/compressed. */
    public val mixedReality: StreamSpec =
        StreamSpec(
            "mixed_reality",
            "picture_center",
            listOf(
                TopicSpec(
                    "image",
                    "mixed_reality/image_raw/compressed",
                    "sensor_msgs/msg/CompressedImage",
                    "mixed_reality",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "camera_info",
                    "mixed_reality/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "mixed_reality/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "color_optical_frame",
            "color_frame",
            "rgb8; jpeg compressed bgr8",
            listOf("android.permission.CAMERA"),
            listOf("camera2", "openxr"),
            listOf(
                Mode(
                    0,
                    listOf("jpeg"),
                    listOf(15, 30, 60),
                    listOf(640 to 480, 1280 to 720, 1280 to 960, 1440 to 1080, 1920 to 1080, 2048 to 1536),
                    mapOf(),
                ),
                Mode(0, listOf("jpeg"), listOf(15, 30), listOf(2880 to 2160, 3840 to 2160, 4096 to 3072), mapOf()),
                Mode(
                    1,
                    listOf("jpeg"),
                    listOf(30, 60),
                    listOf(648 to 720, 972 to 1080, 960 to 720, 1440 to 1080),
                    mapOf(),
                ),
                Mode(1, listOf("jpeg"), listOf(30), listOf(1944 to 2160, 2880 to 2160), mapOf()),
            ),
        )

    /** sensor_msgs/msg/Image on depth/image_raw. */
    public val depth: StreamSpec =
        StreamSpec(
            "depth",
            "depth_center",
            listOf(
                TopicSpec("image", "depth/image_raw", "sensor_msgs/msg/Image", "depth", "image", null, null),
                TopicSpec(
                    "camera_info",
                    "depth/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "depth/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
                TopicSpec(
                    "confidence",
                    "depth/confidence",
                    "sensor_msgs/msg/Image",
                    "depth",
                    "image",
                    "32FC1",
                    "confidence=true",
                ),
                TopicSpec("flags", "depth/flags", "sensor_msgs/msg/Image", "depth", "image", "32SC1", "flags=true"),
            ),
            "depth_optical_frame",
            "depth_frame",
            "32FC1",
            listOf("com.magicleap.permission.DEPTH_CAMERA"),
            listOf("sdk", "openxr"),
            listOf(
                Mode(0, listOf("Depth32", "DepthRaw"), listOf(1, 5), listOf(544 to 480), mapOf()),
                Mode(1, listOf("Depth32", "DepthRaw"), listOf(5, 25, 30, 50, 60), listOf(544 to 480), mapOf(60 to 30)),
            ),
        )

    /** sensor_msgs/msg/Image on infra/image_raw. */
    public val infra: StreamSpec =
        StreamSpec(
            "infra",
            "depth_center",
            listOf(
                TopicSpec("image", "infra/image_raw", "sensor_msgs/msg/Image", "infra", "image", null, null),
                TopicSpec(
                    "camera_info",
                    "infra/camera_info",
                    "sensor_msgs/msg/CameraInfo",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "infra/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "depth_optical_frame",
            "depth_frame",
            "32FC1",
            listOf("com.magicleap.permission.DEPTH_CAMERA"),
            listOf("sdk", "openxr"),
            listOf(
                Mode(0, listOf("Depth32", "DepthRaw"), listOf(1, 5), listOf(544 to 480), mapOf()),
                Mode(1, listOf("Depth32", "DepthRaw"), listOf(5, 25, 30, 50, 60), listOf(544 to 480), mapOf(60 to 30)),
            ),
        )

    /** sensor_msgs/msg/Image on eye_nasal_left/image_raw. */
    public val eyeNasalLeft: StreamSpec =
        StreamSpec(
            "eye_nasal_left",
            "eye_nasal_left",
            listOf(
                TopicSpec(
                    "image",
                    "eye_nasal_left/image_raw",
                    "sensor_msgs/msg/Image",
                    "eye_nasal_left",
                    "image",
                    null,
                    null,
                ),
                TopicSpec("metadata", "eye_nasal_left/metadata", "std_msgs/msg/String", "sensors", "image", null, null),
            ),
            "eye_nasal_left_optical_frame",
            null,
            "mono8",
            listOf("com.magicleap.permission.EYE_CAMERA"),
            listOf("sdk", "openxr"),
            listOf(Mode(0, listOf("Grayscale"), listOf(30), listOf(400 to 400), mapOf())),
        )

    /** sensor_msgs/msg/Image on eye_nasal_right/image_raw. */
    public val eyeNasalRight: StreamSpec =
        StreamSpec(
            "eye_nasal_right",
            "eye_nasal_right",
            listOf(
                TopicSpec(
                    "image",
                    "eye_nasal_right/image_raw",
                    "sensor_msgs/msg/Image",
                    "eye_nasal_right",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "metadata",
                    "eye_nasal_right/metadata",
                    "std_msgs/msg/String",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
            ),
            "eye_nasal_right_optical_frame",
            null,
            "mono8",
            listOf("com.magicleap.permission.EYE_CAMERA"),
            listOf("sdk", "openxr"),
            listOf(Mode(0, listOf("Grayscale"), listOf(30), listOf(400 to 400), mapOf())),
        )

    /** sensor_msgs/msg/Image on eye_temple_left/image_raw. */
    public val eyeTempleLeft: StreamSpec =
        StreamSpec(
            "eye_temple_left",
            "eye_temple_left",
            listOf(
                TopicSpec(
                    "image",
                    "eye_temple_left/image_raw",
                    "sensor_msgs/msg/Image",
                    "eye_temple_left",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "metadata",
                    "eye_temple_left/metadata",
                    "std_msgs/msg/String",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
            ),
            "eye_temple_left_optical_frame",
            null,
            "mono8",
            listOf("com.magicleap.permission.EYE_CAMERA"),
            listOf("sdk", "openxr"),
            listOf(Mode(0, listOf("Grayscale"), listOf(30), listOf(400 to 400), mapOf())),
        )

    /** sensor_msgs/msg/Image on eye_temple_right/image_raw. */
    public val eyeTempleRight: StreamSpec =
        StreamSpec(
            "eye_temple_right",
            "eye_temple_right",
            listOf(
                TopicSpec(
                    "image",
                    "eye_temple_right/image_raw",
                    "sensor_msgs/msg/Image",
                    "eye_temple_right",
                    "image",
                    null,
                    null,
                ),
                TopicSpec(
                    "metadata",
                    "eye_temple_right/metadata",
                    "std_msgs/msg/String",
                    "sensors",
                    "image",
                    null,
                    null,
                ),
            ),
            "eye_temple_right_optical_frame",
            null,
            "mono8",
            listOf("com.magicleap.permission.EYE_CAMERA"),
            listOf("sdk", "openxr"),
            listOf(Mode(0, listOf("Grayscale"), listOf(30), listOf(400 to 400), mapOf())),
        )

    /** sensor_msgs/msg/Imu on accel_left/imu. */
    public val accelLeft: StreamSpec =
        StreamSpec(
            "accel_left",
            "other_sensors",
            listOf(TopicSpec("imu", "accel_left/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_left_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on accel_right/imu. */
    public val accelRight: StreamSpec =
        StreamSpec(
            "accel_right",
            "other_sensors",
            listOf(TopicSpec("imu", "accel_right/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_right_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on accel_compute_pack/imu. */
    public val accelComputePack: StreamSpec =
        StreamSpec(
            "accel_compute_pack",
            "other_sensors",
            listOf(TopicSpec("imu", "accel_compute_pack/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_compute_pack_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on gyro_left/imu. */
    public val gyroLeft: StreamSpec =
        StreamSpec(
            "gyro_left",
            "other_sensors",
            listOf(TopicSpec("imu", "gyro_left/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_left_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on gyro_right/imu. */
    public val gyroRight: StreamSpec =
        StreamSpec(
            "gyro_right",
            "other_sensors",
            listOf(TopicSpec("imu", "gyro_right/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_right_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on gyro_compute_pack/imu. */
    public val gyroComputePack: StreamSpec =
        StreamSpec(
            "gyro_compute_pack",
            "other_sensors",
            listOf(TopicSpec("imu", "gyro_compute_pack/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_compute_pack_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on imu_left/imu. */
    public val imuLeft: StreamSpec =
        StreamSpec(
            "imu_left",
            "imu",
            listOf(TopicSpec("imu", "imu_left/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_left_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on imu_right/imu. */
    public val imuRight: StreamSpec =
        StreamSpec(
            "imu_right",
            "imu",
            listOf(TopicSpec("imu", "imu_right/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_right_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Imu on imu_compute_pack/imu. */
    public val imuComputePack: StreamSpec =
        StreamSpec(
            "imu_compute_pack",
            "imu",
            listOf(TopicSpec("imu", "imu_compute_pack/imu", "sensor_msgs/msg/Imu", "sensors", "imu", null, null)),
            "imu_compute_pack_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/Illuminance on light_sensor. */
    public val lightSensor: StreamSpec =
        StreamSpec(
            "light_sensor",
            "other_sensors",
            listOf(
                TopicSpec(
                    "illuminance",
                    "light_sensor",
                    "sensor_msgs/msg/Illuminance",
                    "sensors",
                    "sensor",
                    null,
                    null,
                ),
            ),
            "head_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** geometry_msgs/msg/PoseStamped on head_pose. */
    public val headPose: StreamSpec =
        StreamSpec(
            "head_pose",
            "head_pose",
            listOf(TopicSpec("pose", "head_pose", "geometry_msgs/msg/PoseStamped", "sensors", "sensor", null, null)),
            "magicleap_world",
            null,
            null,
            listOf(),
            listOf("sdk", "openxr"),
            listOf(),
        )

    /** sensor_msgs/msg/MagneticField on magnetometer_left. */
    public val magnetometerLeft: StreamSpec =
        StreamSpec(
            "magnetometer_left",
            "magnetometer",
            listOf(
                TopicSpec(
                    "magnetic_field",
                    "magnetometer_left",
                    "sensor_msgs/msg/MagneticField",
                    "sensors",
                    "sensor",
                    null,
                    null,
                ),
            ),
            "imu_left_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/MagneticField on magnetometer_right. */
    public val magnetometerRight: StreamSpec =
        StreamSpec(
            "magnetometer_right",
            "magnetometer",
            listOf(
                TopicSpec(
                    "magnetic_field",
                    "magnetometer_right",
                    "sensor_msgs/msg/MagneticField",
                    "sensors",
                    "sensor",
                    null,
                    null,
                ),
            ),
            "imu_right_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/FluidPressure on pressure_headset. */
    public val pressureHeadset: StreamSpec =
        StreamSpec(
            "pressure_headset",
            "pressure",
            listOf(
                TopicSpec(
                    "pressure",
                    "pressure_headset",
                    "sensor_msgs/msg/FluidPressure",
                    "sensors",
                    "sensor",
                    null,
                    null,
                ),
            ),
            "head_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** sensor_msgs/msg/FluidPressure on pressure_compute_pack. */
    public val pressureComputePack: StreamSpec =
        StreamSpec(
            "pressure_compute_pack",
            "pressure",
            listOf(
                TopicSpec(
                    "pressure",
                    "pressure_compute_pack",
                    "sensor_msgs/msg/FluidPressure",
                    "sensors",
                    "sensor",
                    null,
                    null,
                ),
            ),
            "imu_compute_pack_frame",
            null,
            null,
            listOf(),
            listOf("sensor_manager"),
            listOf(),
        )

    /** geometry_msgs/msg/PoseStamped on gaze. */
    public val gaze: StreamSpec =
        StreamSpec(
            "gaze",
            "gaze",
            listOf(TopicSpec("pose", "gaze", "geometry_msgs/msg/PoseStamped", "sensors", "sensor", null, null)),
            "magicleap_world",
            null,
            null,
            listOf("com.magicleap.permission.EYE_TRACKING"),
            listOf("sdk", "openxr"),
            listOf(),
        )

    /** geometry_msgs/msg/PoseArray on hand_left. */
    public val handLeft: StreamSpec =
        StreamSpec(
            "hand_left",
            "hands",
            listOf(TopicSpec("poses", "hand_left", "geometry_msgs/msg/PoseArray", "sensors", "sensor", null, null)),
            "magicleap_world",
            null,
            null,
            listOf("com.magicleap.permission.HAND_TRACKING"),
            listOf("sdk", "openxr"),
            listOf(),
        )

    /** geometry_msgs/msg/PoseArray on hand_right. */
    public val handRight: StreamSpec =
        StreamSpec(
            "hand_right",
            "hands",
            listOf(TopicSpec("poses", "hand_right", "geometry_msgs/msg/PoseArray", "sensors", "sensor", null, null)),
            "magicleap_world",
            null,
            null,
            listOf("com.magicleap.permission.HAND_TRACKING"),
            listOf("sdk", "openxr"),
            listOf(),
        )

    /** sensor_msgs/msg/BatteryState on battery. */
    public val battery: StreamSpec =
        StreamSpec(
            "battery",
            "battery",
            listOf(TopicSpec("battery", "battery", "sensor_msgs/msg/BatteryState", "sensors", "sensor", null, null)),
            "head_frame",
            null,
            null,
            listOf(),
            listOf("battery_manager"),
            listOf(),
        )

    /** tf2_msgs/msg/TFMessage on /tf. */
    public val tf: StreamSpec =
        StreamSpec(
            "tf",
            "tf",
            listOf(
                TopicSpec("tf", "/tf", "tf2_msgs/msg/TFMessage", "sensors", "tf", null, null),
                TopicSpec(
                    "tf_static",
                    "/tf_static",
                    "tf2_msgs/msg/TFMessage",
                    "sensors",
                    "latched",
                    null,
                    "layout=rig",
                ),
            ),
            "magicleap_world",
            null,
            null,
            listOf(),
            listOf("sdk", "openxr"),
            listOf(),
        )

    /** Messages that the app on the headset publishes by itself. */
    public val custom: StreamSpec =
        StreamSpec("custom", "custom", listOf(), "", null, null, listOf(), listOf("app"), listOf())

    /** Of the topics of [custom]. */
    internal val customTopics: CustomTopicsSpec =
        CustomTopicsSpec("custom", "sensors", "sensor", 32)

    /** In the order of the file. */
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
        )

    /** Null where the table has no such stream. */
    public fun byId(id: String): StreamSpec? = all.firstOrNull { it.id == id }
}
