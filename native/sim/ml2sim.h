/**
 * Controls the simulated headset, and gives its ground truth. libperception.magicleap.so exports these functions beside
 * the vendor's.
 *
 * **World.** The scene is a closed room in which the head moves. Scene and motion depend only on the seed and on
 * MLTime. Axes of the world and of sensors are x right, y up, z backward (RUB). Rotations are x, y, z, w; lengths are
 * in metres, times in nanoseconds. The origin of the world is that of the current head tracking session and is gravity
 * aligned; in the first session it is the origin of the scene.
 *
 * **Time.** MLTime is (1 + skew) times CLOCK_MONOTONIC, plus a large offset. With the key clock=manual, only
 * ml2sim_advance changes MLTime, and with it CLOCK_MONOTONIC and CLOCK_BOOTTIME as this library takes and returns them.
 *
 * **Misuse.** A call that breaks a rule of the vendor's interface is refused, logged to stderr and counted in
 * ml2sim_get_counters. Reading a frame after its release is a segmentation fault.
 *
 * **Threads.** Every function is thread-safe.
 */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ML2SIM_API __attribute__((visibility("default")))

/**
 * Sets a key of ml2sim_describe_keys, such as ("fault.world.stalled", "1"). Returns null, or an error that names the
 * allowed values (valid until this thread's next call). Keys can be set at any time. The environment variable ML2SIM,
 * "key=value,key=value", is read when the library is loaded; the process aborts if it has a mistake.
 */
ML2SIM_API const char *ml2sim_set(const char *key, const char *value);

/**
 * One line for each key, with tabs between: name, value, default, kind (whole, real or text), least, most, choices with
 * | between (a text with none takes any text), meaning. Valid until this thread's next call.
 */
ML2SIM_API const char *ml2sim_describe_keys(void);

/** Resets keys, counters, open handles and the tracking session. For tests. */
ML2SIM_API void ml2sim_reset(void);

typedef enum ml2sim_misuse {
    ML2SIM_MISUSE_VERSION =
        0, /**< A version other than that of the Init function, or a structure that is not initialised. */
    ML2SIM_MISUSE_ARGUMENT = 1,   /**< Null, unknown bits, or a value that the vendor does not list. */
    ML2SIM_MISUSE_HANDLE = 2,     /**< A handle that does not exist or is closed. */
    ML2SIM_MISUSE_THREAD = 3,     /**< A handle used by a thread that did not open it, or by two at once. */
    ML2SIM_MISUSE_GET_TWICE = 4,  /**< Get before the previous data was released. */
    ML2SIM_MISUSE_RELEASE = 5,    /**< Released twice, or without a get. */
    ML2SIM_MISUSE_UNRELEASED = 6, /**< Closed before its data was released. */
    ML2SIM_MISUSE_CLIENTS = 7,    /**< A second connection to a sensor that has one. */
    ML2SIM_MISUSE_COUNT = 8,
} ml2sim_misuse;

/** Open resources, and misuses since the start or ml2sim_reset. All are zero when a correct program ends. */
typedef struct ml2sim_counters {
    uint32_t open_handles;
    uint32_t outstanding_gets;
    uint32_t outstanding_snapshots;
    uint32_t outstanding_capability_lists;
    uint32_t is_perception_started;
    uint32_t misuses[ML2SIM_MISUSE_COUNT]; /**< By ml2sim_misuse. Each also prints a line on stderr. */
    char last_misuse[240];                 /**< Empty when there was none. */
} ml2sim_counters;

ML2SIM_API void ml2sim_get_counters(ml2sim_counters *out);

/**
 * Returns how many captures all cameras have left out since the start or ml2sim_reset. A frame is rendered when it is
 * first shown, which takes milliseconds. Captures that fall due meanwhile do not happen, except the newest; they have
 * no frame number.
 */
ML2SIM_API uint64_t ml2sim_captures_left_out(void);

/** The images that a camera shows in one mode. A member that its kind of camera has not is not read. */
typedef struct ml2sim_images {
    const char *camera; /**< world_left and so on, eye_temple_left and so on, color, mixed_reality, depth_long or
                             depth_short. */
    uint32_t width;     /**< In pixels, as height: for color and mixed_reality. */
    uint32_t height;
    uint32_t rate_hz;      /**< For color, mixed_reality and depth. */
    uint32_t low_exposure; /**< For world cameras, 1 for images of low exposure. */
    uint32_t depth_planes; /**< For depth, MLDepthCameraFlags. */
} ml2sim_images;

/**
 * Renders all images of a camera that are not yet in the folder of the key `cache`, in the calling thread, so that
 * cameras of later processes leave out no captures. It takes some 30 ms for each. Returns 0; 1 if there is no folder,
 * or no room in it, and then ends early; -1 if the device has no such mode.
 */
ML2SIM_API int32_t ml2sim_draw(const ml2sim_images *images);

ML2SIM_API int64_t ml2sim_now_mltime(void);
ML2SIM_API int64_t ml2sim_now_boottime(void);
ML2SIM_API int64_t ml2sim_mltime_of_boottime(int64_t boottime_nanos);
ML2SIM_API int64_t ml2sim_boottime_of_mltime(int64_t mltime_nanos);

/** Advances MLTime, with clock=manual, and wakes waiting threads. */
ML2SIM_API void ml2sim_advance(int64_t nanos);

typedef enum ml2sim_camera {
    ML2SIM_WORLD_LEFT = 0,
    ML2SIM_WORLD_RIGHT = 1,
    ML2SIM_WORLD_CENTER = 2,
    ML2SIM_DEPTH = 3,
    ML2SIM_COLOR = 4,
    ML2SIM_CAMERA_COUNT = 5,
} ml2sim_camera;

typedef enum ml2sim_unit {
    ML2SIM_HEADSET_LEFT = 0,
    ML2SIM_HEADSET_RIGHT = 1,
    ML2SIM_COMPUTE_PACK = 2,
    ML2SIM_UNIT_COUNT = 3,
} ml2sim_unit;

typedef struct ml2sim_pose {
    double rotation[4];
    double position[3];
} ml2sim_pose;

/** Writes the true pose of a camera, tracked or not. Returns 0, or -1 for an unknown camera. */
ML2SIM_API int32_t ml2sim_true_pose(uint32_t camera, int64_t mltime_nanos, ml2sim_pose *out);

ML2SIM_API void ml2sim_true_head(int64_t mltime_nanos, ml2sim_pose *out);

/** Writes the pose of the head that head tracking reports, with its errors. While tracking is lost, it is the last. */
ML2SIM_API void ml2sim_reported_head(int64_t mltime_nanos, ml2sim_pose *out);

/**
 * Writes the measurements of an inertial unit in its Android axes: specific force in m/s^2 (9.81 upwards at rest),
 * angular velocity in rad/s, magnetic field in tesla. Bias and noise follow the keys; equal times give equal values.
 * The noise is that of 200 samples per second, of the magnetic field 50. The compute pack swings while there is noise.
 * Any of the three may be null. Returns 0, or -1 for an unknown unit.
 */
ML2SIM_API int32_t ml2sim_imu(uint32_t unit, int64_t boottime_nanos, float accel[3], float gyro[3], float mag[3]);

/** Returns the ambient light in lux. */
ML2SIM_API float ml2sim_light(int64_t boottime_nanos);

/** Returns the air pressure at a unit in pascal, or -1 for an unknown unit. */
ML2SIM_API float ml2sim_pressure(uint32_t unit, int64_t boottime_nanos);

typedef struct ml2sim_color_request {
    uint32_t width;
    uint32_t height;
    uint32_t rate_hz;       /**< 15, 30 or 60. */
    uint32_t with_hologram; /**< 1: mixed reality, with a hologram over the image. */
} ml2sim_color_request;

typedef struct ml2sim_color_frame {
    const uint8_t *jpeg; /**< Read-only; valid until the process ends. */
    uint32_t jpeg_bytes;
    uint32_t reserved;
    int64_t frame_number;
    int64_t capture_mltime; /**< Centre of exposure. */
    int64_t exposure_nanos;
    int64_t next_boottime; /**< Delivery of the next frame. */
    float intrinsics[12];  /**< As the vendor tag: w, h, fx, fy, cx, cy, fov in degrees, k1, k2, p1, p2, k3. */
} ml2sim_color_frame;

/**
 * Writes the newest frame of the colour camera that is delivered by a time. Returns 0, or -1 if the device does not
 * have the size or rate.
 */
ML2SIM_API int32_t ml2sim_color(const ml2sim_color_request *request, int64_t boottime_nanos, ml2sim_color_frame *out);

/**
 * Writes the pixels of a frame of ml2sim_color in NV21: rows of brightness, then of pairs of V and U, without padding;
 * 1.5 bytes for each pixel.
 */
ML2SIM_API void ml2sim_color_pixels(const uint8_t *jpeg, uint32_t jpeg_bytes, uint8_t *nv21);

/**
 * Returns the known points of the scene, {"tags": [{"id", "corners": [[x, y, z] x 4]}], "walls": [{"normal",
 * "offset_m"}]}, as world positions in metres. Each point p of a wall has normal . p = offset_m. Valid until this
 * thread's next call.
 */
ML2SIM_API const char *ml2sim_landmarks(void);

/**
 * Returns the poses of sensors in the head, {"<sensor>": {"rotation": [x, y, z, w], "position": [x, y, z]}}. Inertial
 * units also have "late_s", by how much their stamps are late. Valid until this thread's next call.
 */
ML2SIM_API const char *ml2sim_mounts(void);

#ifdef __cplusplus
}
#endif
