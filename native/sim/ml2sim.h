/**
 * Control and truth of the simulated headset: what no vendor interface offers. libperception.magicleap.so exports it
 * beside the vendor's symbols; anything that needs pictures, poses and motions of one same headset asks here.
 *
 * **World.** A closed room and a head that moves through it, a pure function of the seed and of MLTime. Axes are the
 * device's: x right, y up, z backward (RUB) for the world as for the thing; rotations x, y, z, w; metres; nanoseconds.
 * The world's origin is that of the current head tracking session (the room's own in the first), gravity aligned.
 *
 * **Time.** MLTime runs at (1 + skew) of CLOCK_MONOTONIC plus a large offset. With the key clock=manual time stands
 * still but for ml2sim_advance, and the times of CLOCK_MONOTONIC and CLOCK_BOOTTIME that this library takes and gives
 * stand with it.
 *
 * **Misuse.** What breaks a rule of the vendor's interfaces is refused, told on stderr and counted in ml2sim_books.
 * Frames that were released cannot be read: touching them is a segmentation fault.
 *
 * **Threads.** Every function here may be called from any thread.
 */
#pragma once

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ML2SIM_API __attribute__((visibility("default")))

/**
 * Sets a key of ml2sim_describe_keys, such as ("fault.world.stalled", "1"), at any time. The variable ML2SIM of the
 * environment, "key=value,key=value", is read so when the library is first used; a mistake in it aborts.
 * Returns null, or what is wrong and what is allowed (valid until this thread's next call).
 */
ML2SIM_API const char *ml2sim_set(const char *key, const char *value);

/**
 * One line for each key, with tabs between: name, value, default, kind (whole, real or text), least, most, choices with
 * | between (a text with none takes any text), meaning. Valid until this thread's next call.
 */
ML2SIM_API const char *ml2sim_describe_keys(void);

/** 1 while somebody waits for pictures to be drawn, which takes all processors for seconds; else 0. */
ML2SIM_API int32_t ml2sim_is_drawing(void);

/** All keys as at the start, everything that is open forgotten, books empty, a new first session; for tests. */
ML2SIM_API void ml2sim_reset(void);

typedef enum ml2sim_misuse {
    ML2SIM_MISUSE_VERSION = 0,    /**< A version field other than what Init writes, or a struct not initialised. */
    ML2SIM_MISUSE_ARGUMENT = 1,   /**< Null, unknown bits, a value out of its table. */
    ML2SIM_MISUSE_HANDLE = 2,     /**< A handle that was never given or is closed. */
    ML2SIM_MISUSE_THREAD = 3,     /**< A handle used from a thread that is not its own, or from two at once. */
    ML2SIM_MISUSE_GET_TWICE = 4,  /**< Get before the last data was released. */
    ML2SIM_MISUSE_RELEASE = 5,    /**< Release of what was not got, or twice. */
    ML2SIM_MISUSE_UNRELEASED = 6, /**< Closed with data that was not released. */
    ML2SIM_MISUSE_CLIENTS = 7,    /**< A second connection to a sensor that has one. */
    ML2SIM_MISUSE_COUNT = 8,
} ml2sim_misuse;

/** What is open and what was done wrong since the start or ml2sim_reset. All zero is a perfect program's end. */
typedef struct ml2sim_book {
    uint32_t open_handles;
    uint32_t outstanding_gets;
    uint32_t outstanding_snapshots;
    uint32_t outstanding_capability_lists;
    uint32_t is_perception_started;
    uint32_t misuses[ML2SIM_MISUSE_COUNT]; /**< By ml2sim_misuse. Each also prints a line on stderr. */
    char last_misuse[240];                 /**< Empty when there was none. */
} ml2sim_book;

ML2SIM_API void ml2sim_books(ml2sim_book *out);

ML2SIM_API int64_t ml2sim_now_mltime(void);
ML2SIM_API int64_t ml2sim_now_boottime(void);
ML2SIM_API int64_t ml2sim_mltime_of_boottime(int64_t boottime_nanos);
ML2SIM_API int64_t ml2sim_boottime_of_mltime(int64_t mltime_nanos);

/** Lets time go on, with clock=manual; whoever waits for it wakes. */
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

/** Where a camera truly is at an MLTime, whether or not tracking is valid. Returns 0, or -1 for an unknown camera. */
ML2SIM_API int32_t ml2sim_true_pose(uint32_t camera, int64_t mltime_nanos, ml2sim_pose *out);

ML2SIM_API void ml2sim_true_head(int64_t mltime_nanos, ml2sim_pose *out);

/**
 * What an inertial unit measures, in its own Android axes: specific force in m/s^2 (9.81 upwards at rest), angular
 * velocity in rad/s, magnetic field in tesla; bias and noise as the keys say, equal for equal times. Any of the
 * three may be null. Returns 0, or -1 for an unknown unit.
 */
ML2SIM_API int32_t ml2sim_imu(uint32_t unit, int64_t boottime_nanos, float accel[3], float gyro[3], float mag[3]);

/** Ambient light in lux. */
ML2SIM_API float ml2sim_light(int64_t boottime_nanos);

/** Air pressure at a unit in pascal; -1 for an unknown unit. */
ML2SIM_API float ml2sim_pressure(uint32_t unit, int64_t boottime_nanos);

typedef struct ml2sim_color_request {
    uint32_t width;
    uint32_t height;
    uint32_t rate_hz;       /**< 15, 30 or 60. */
    uint32_t with_hologram; /**< 1: mixed reality, a hologram drawn over the room. */
} ml2sim_color_request;

typedef struct ml2sim_color_frame {
    const uint8_t *jpeg; /**< Read only; valid until the process ends. */
    uint32_t jpeg_bytes;
    uint32_t reserved;
    int64_t frame_number;
    int64_t capture_mltime; /**< Centre of exposure. */
    int64_t exposure_nanos;
    int64_t next_boottime; /**< When the next frame will be delivered. */
    float intrinsics[12];  /**< As the vendor tag: w, h, fx, fy, cx, cy, fov in degrees, k1, k2, p1, p2, k3. */
} ml2sim_color_frame;

/**
 * The newest frame of the colour camera that is delivered by a time. Draws the whole loop when a request is first
 * made (seconds); instant ever after. Returns 0, or -1 when the size or rate is not one of the device's.
 */
ML2SIM_API int32_t ml2sim_color(const ml2sim_color_request *request, int64_t boottime_nanos, ml2sim_color_frame *out);

/**
 * The known points of the room, {"tags": [{"id", "corners": [[x, y, z] x 4]}], "walls": [{"normal", "offset_m"}]}:
 * world positions in metres, points p of a wall have normal . p = offset_m. Valid until this thread's next call.
 */
ML2SIM_API const char *ml2sim_landmarks(void);

/** {"<sensor>": {"rotation": [x, y, z, w], "position": [x, y, z]}}: sensors in the head. Valid like the above. */
ML2SIM_API const char *ml2sim_mounts(void);

#ifdef __cplusplus
}
#endif
