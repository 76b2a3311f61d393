/**
 * The C interface of libml2sensors.so: the headset's pixel sensors and tracked poses.
 *
 * Kotlin reaches it through JNI, C# through P/Invoke, both the same functions. Everything is in nanoseconds, metres,
 * bytes and pixels. Poses have the device's own axes: x right, y up, z backward (RUB), for the world as for the thing;
 * rotations are x, y, z, w.
 *
 * **Memory.** Frames are copied once, from the vendor's memory into a *slot*: memory that the caller provides per
 * stream with ml2s_provide and keeps until it takes it back. Without that, the Kotlin library lets slots have memory of
 * the library's own while a stream runs; a leased frame keeps its memory when its stream ends. A slot is written by one
 * writer (ml2s_poll, or a caller between ml2s_take and ml2s_publish) and then leased to readers, each of which gives
 * it back with one ml2s_release. When every slot of a stream is leased, its next frame is lost and said to be lost:
 * a slow reader never stalls a camera.
 *
 * **Threads.** A handle belongs to the thread that opened it: every call with a handle must come from there, others
 * get ML2S_WRONG_THREAD. ml2s_poll may block for its timeout. Slot functions may be called from any thread and never
 * block.
 *
 * **Versions.** Every structure begins with struct_size, which the caller sets to sizeof; not so ml2s_plane and
 * ml2s_memory, which stay as they are. A size smaller than this header's first version is ML2S_INVALID_ARGUMENT; fields
 * are only ever appended. Fields named reserved are 0.
 */
#pragma once

#include <stdint.h>

#include "../generated/ml2s_streams.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ML2S_API __attribute__((visibility("default")))
#define ML2S_ABI_VERSION 1u
#define ML2S_MAX_SLOTS 8u
#define ML2S_NO_SLOT UINT32_MAX
/** A second of the tracking cameras: an odd frame passes, a device that differs from what is known here does not. */
#define ML2S_MOST_ODD_CAPTURES 30u
#define ML2S_STREAM_BIT(stream) (UINT64_C(1) << (stream))

/** One opened sensor. 0 is never valid; a closed handle stays invalid for ever. */
typedef uint64_t ml2s_handle;

/** What became of a call. */
typedef enum ml2s_result {
    /** Done. */
    ML2S_OK = 0,
    /** Nothing new within the timeout: expected, not an error. */
    ML2S_TIMEOUT = 1,
    /** A value, size or null that the call does not take; the caller is to be mended. */
    ML2S_INVALID_ARGUMENT = 2,
    /** Another thread opened the handle. */
    ML2S_WRONG_THREAD = 3,
    /** The handle was closed or never opened. */
    ML2S_CLOSED = 4,
    /** A library or symbol is missing, or the device has no such sensor; the message names it. */
    ML2S_NOT_AVAILABLE = 5,
    /** The app lacks the Android permission of the sensor. */
    ML2S_PERMISSION_DENIED = 6,
    /** All slots of the stream are leased, or none were provided. */
    ML2S_ALL_SLOTS_LEASED = 7,
    /** All handles are in use, or slots to be taken back are still leased. */
    ML2S_BUSY = 8,
    /** The vendor's call failed; vendor_code and the message say how. */
    ML2S_VENDOR_FAILURE = 9,
    /** No pose at that time: outside the vendor's history, not tracked, or the vendor's call for it failed. */
    ML2S_NO_POSE = 10,
} ml2s_result;

/** What went wrong, for people: set whenever a call with one returns neither ML2S_OK nor ML2S_TIMEOUT. */
typedef struct ml2s_error {
    uint32_t struct_size;
    int32_t vendor_code; /**< MLResult or XrResult; 0 when the vendor was not reached. */
    char message[248];   /**< Zero-terminated ASCII, such as "not available:
                            libperception.magicleap.so/MLEyeCameraConnect". */
} ml2s_error;

/** The way to the sensors. */
typedef enum ml2s_backend {
    ML2S_BACKEND_SDK = 0,    /**< The vendor's C SDK. */
    ML2S_BACKEND_OPENXR = 1, /**< OpenXR with the vendor's extensions, after ml2s_use_openxr. */
} ml2s_backend;

/** What one handle drives. A sensor can be open once per backend. */
typedef enum ml2s_sensor {
    ML2S_SENSOR_DEPTH = 1, /**< ML2S_STREAM_DEPTH or ML2S_STREAM_INFRA, one at a time. */
    ML2S_SENSOR_WORLD = 2, /**< Any of ML2S_STREAM_WORLD_*. */
    ML2S_SENSOR_EYE = 3,   /**< Any of ML2S_STREAM_EYE_*. */
    ML2S_SENSOR_HEAD = 4,  /**< ML2S_STREAM_HEAD_POSE, by ml2s_poll_poses. */
    ML2S_SENSOR_COLOR = 5, /**< SDK: only ml2s_color_pose. OpenXR: ML2S_STREAM_COLOR or ML2S_STREAM_MIXED_REALITY. */
    ML2S_SENSOR_GAZE = 6,  /**< ML2S_STREAM_GAZE, by ml2s_poll_poses. */
    ML2S_SENSOR_HANDS = 7, /**< ML2S_STREAM_HAND_*, by ml2s_poll_poses. */
} ml2s_sensor;

enum {
    ML2S_WANT_CONFIDENCE = 1u << 0, /**< Depth: fill the confidence plane. */
    ML2S_WANT_FLAGS = 1u << 1,      /**< Depth: fill the flags plane, with the bits of the backend that is used. */
    ML2S_WANT_RADIAL = 1u << 2,     /**< Depth: distance from the camera instead of z along its optical axis. */
};

/** What a handle is to deliver. */
typedef struct ml2s_settings {
    uint32_t struct_size;
    uint32_t sensor;         /**< ml2s_sensor */
    uint32_t backend;        /**< ml2s_backend */
    uint32_t wants;          /**< ML2S_WANT_* */
    uint64_t streams;        /**< ML2S_STREAM_BITs to deliver; at least one. */
    uint64_t second_streams; /**< Those of them that run as stream 1: low exposure, short range. */
    uint32_t rate_hz;        /**< Depth and OpenXR; others run as the device does. */
    uint32_t width;          /**< OpenXR; others have one size. */
    uint32_t height;         /**< As width. */
    uint32_t reserved;
} ml2s_settings;

enum {
    ML2S_HAS_POSE = 1u << 0,         /**< rotation and position */
    ML2S_HAS_INTRINSICS = 1u << 1,   /**< lens, focal_length, principal_point and distortion */
    ML2S_HAS_EXPOSURE = 1u << 2,     /**< exposure_nanos */
    ML2S_HAS_ANALOG_GAIN = 1u << 3,  /**< analog_gain */
    ML2S_HAS_DIGITAL_GAIN = 1u << 4, /**< digital_gain */
    ML2S_HAS_ILLUMINATION = 1u << 5, /**< illumination */
    ML2S_HAS_HEAD_POSE = 1u << 6,    /**< head_rotation and head_position */
};

/** The model of a lens. */
typedef enum ml2s_lens {
    ML2S_LENS_PLUMB_BOB = 0,          /**< distortion: k1 k2 p1 p2 k3 */
    ML2S_LENS_FISHEYE_TANGENTIAL = 1, /**< distortion: k1 k2 k3 k4 p1 p2; equidistant, then tangential. */
} ml2s_lens;

/** The places in ml2s_frame.planes. */
typedef enum ml2s_plane_role {
    ML2S_PLANE_IMAGE = 0,      /**< The pixels, or one JPEG. */
    ML2S_PLANE_CONFIDENCE = 1, /**< Depth, with ML2S_WANT_CONFIDENCE: 32-bit floats. */
    ML2S_PLANE_FLAGS = 2,      /**< Depth, with ML2S_WANT_FLAGS: 32-bit words. */
    ML2S_PLANE_COUNT = 3,      /**< How many there are. */
} ml2s_plane_role;

/** Part of a slot; size_bytes is 0 when absent. */
typedef struct ml2s_plane {
    uint32_t offset_bytes; /**< From the frame's data. */
    uint32_t size_bytes;   /**< Of all its rows, or of the JPEG. */
    uint32_t stride_bytes; /**< From one row to the next; 0 for JPEG. */
    uint32_t reserved;
} ml2s_plane;

/** One capture. Valid while the slot is leased. */
typedef struct ml2s_frame {
    uint32_t struct_size;
    uint32_t stream;      /**< ml2s_stream */
    uint32_t slot;        /**< ML2S_NO_SLOT when there is no picture: without width for want of a usable frame, else for
                             want of a slot. */
    uint32_t has;         /**< ML2S_HAS_* */
    int64_t frame_number; /**< The device's own; gaps are frames that the device dropped. */
    int64_t capture_nanos;               /**< CLOCK_BOOTTIME */
    int64_t device_nanos;                /**< The same instant as MLTime or XrTime. */
    uint8_t *data;                       /**< The slot's memory. */
    ml2s_plane planes[ML2S_PLANE_COUNT]; /**< By ml2s_plane_role. */
    uint32_t width;                      /**< Pixels per row. */
    uint32_t height;                     /**< Rows. */
    float rotation[4];                   /**< Of the camera in the world: x, y, z, w. */
    float position[3];                   /**< Of the camera in the world. */
    uint32_t lens;                       /**< ml2s_lens */
    double focal_length[2];              /**< x, y. */
    double principal_point[2];           /**< x, y, from the top left. */
    double distortion[6];                /**< As lens says; the rest is 0. */
    int64_t exposure_nanos;              /**< How long light was collected. */
    uint32_t analog_gain;                /**< The device's own unit. */
    uint32_t digital_gain;               /**< The device's own unit. */
    uint32_t illumination;               /**< 1 when the depth camera's light was on. */
    uint32_t skipped;                    /**< Odd frames of the stream that were skipped: see ml2s_poll. */
    float head_rotation[4];              /**< Of the head in the world at the capture: x, y, z, w. */
    float head_position[3];              /**< Of the head in the world at the capture. */
    uint32_t reserved;
} ml2s_frame;

enum {
    ML2S_TRACKING_LOST = 1u << 0,            /**< The headset does not know where it is. */
    ML2S_TRACKING_RECOVERED = 1u << 1,       /**< It knows again, in the same world. */
    ML2S_TRACKING_RECOVERY_FAILED = 1u << 2, /**< It gave up the old world. */
    ML2S_TRACKING_NEW_SESSION = 1u << 3,     /**< Poses are in a new world. */
};

/** Where something was. */
typedef struct ml2s_pose {
    uint32_t struct_size;
    uint32_t stream;       /**< ml2s_stream */
    int64_t capture_nanos; /**< CLOCK_BOOTTIME of the instant that the pose is for. */
    int64_t device_nanos;  /**< The same instant as MLTime or XrTime. */
    float rotation[4];     /**< In the world: x, y, z, w. */
    float position[3];     /**< In the world. */
    uint32_t is_tracked;   /**< 0: rotation and position mean nothing. */
    uint32_t events;       /**< ML2S_TRACKING_* since the last poll. */
    uint32_t reserved;
} ml2s_pose;

/** Memory of one slot, aligned to 64. */
typedef struct ml2s_memory {
    uint8_t *data;       /**< The caller's. */
    uint64_t size_bytes; /**< What fits. */
} ml2s_memory;

/** ML2S_ABI_VERSION of the library; it grows when what callers were compiled with no longer works. */
ML2S_API uint32_t ml2s_abi_version(void);

/** CLOCK_BOOTTIME now. */
ML2S_API int64_t ml2s_now(void);

/** The CLOCK_BOOTTIME instant of an MLTime (or XrTime, which is the same on this device). Any thread. */
ML2S_API ml2s_result ml2s_boottime_of(int64_t device_nanos, int64_t *capture_nanos, ml2s_error *error);

/** Whether ml2s_open would find the library and symbols that a sensor needs; the device is not touched. Any thread. */
ML2S_API ml2s_result ml2s_check(uint32_t sensor, uint32_t backend, ml2s_error *error);

/** Opens a sensor and begins its streams. error may be null, here and everywhere. */
ML2S_API ml2s_result ml2s_open(const ml2s_settings *settings, ml2s_handle *out, ml2s_error *error);

/** Other streams or values for an open sensor; the old ones go on when it fails. */
ML2S_API ml2s_result ml2s_configure(ml2s_handle handle, const ml2s_settings *settings, ml2s_error *error);

/**
 * Waits until the sensor has captured, and delivers the frames of that moment, at most one per stream, each leased to
 * the caller (or lost: see ml2s_frame.slot). capacity should be that of all its streams; more are lost.
 *
 * A frame of the vendor's that is not as expected (a picture beyond its memory, an unknown camera, a second frame of
 * one camera, another size, no time) is skipped, and counted in skipped of its stream's ml2s_frame. After
 * ML2S_MOST_ODD_CAPTURES moments in a row without a usable frame the poll fails, and says what was wrong with the last.
 */
ML2S_API ml2s_result ml2s_poll(ml2s_handle handle, uint64_t timeout_nanos, ml2s_frame *frames, uint32_t capacity,
                               uint32_t *count, ml2s_error *error);

/**
 * The poses of now: one for HEAD and GAZE; for HANDS always 26 per hand, in the order of XrHandJointEXT, each tracked
 * or not.
 */
ML2S_API ml2s_result ml2s_poll_poses(ml2s_handle handle, ml2s_pose *poses, uint32_t capacity, uint32_t *count,
                                     ml2s_error *error);

/** Where the colour camera was at device_nanos; to be asked at once per frame, the device remembers little. */
ML2S_API ml2s_result ml2s_color_pose(ml2s_handle handle, int64_t device_nanos, ml2s_pose *pose, ml2s_error *error);

/**
 * The rates in Hz that the device has here for the streams of an open handle, as far as there is room. DEPTH with
 * ML2S_BACKEND_SDK alone: light of 50 Hz mains excludes 30 and 60, light of 60 Hz mains 25 and 50.
 */
ML2S_API ml2s_result ml2s_list_rates(ml2s_handle handle, uint32_t *rates_hz, uint32_t capacity, uint32_t *count,
                                     ml2s_error *error);

/** Gives the device back to others while the app is not in front; polls time out. */
ML2S_API ml2s_result ml2s_pause(ml2s_handle handle, ml2s_error *error);

/** Takes it again after ml2s_pause. */
ML2S_API ml2s_result ml2s_resume(ml2s_handle handle, ml2s_error *error);

/** Always closes; leased slots stay valid. */
ML2S_API ml2s_result ml2s_close(ml2s_handle handle, ml2s_error *error);

/**
 * Gives a stream its slots, at most ML2S_MAX_SLOTS, instead of those it had; count 0 takes them back. ML2S_BUSY while
 * any of them is leased. The memory stays the caller's and must live until it is taken back.
 */
ML2S_API ml2s_result ml2s_provide(uint32_t stream, const ml2s_memory *slots, uint32_t count);

/** A free slot to write a frame into; then ml2s_publish, or ml2s_release to give it up. */
ML2S_API ml2s_result ml2s_take(uint32_t stream, uint32_t *slot, ml2s_memory *memory);

/** Makes frame, in the taken slot frame->slot, the latest of its stream; the writer keeps its own lease. */
ML2S_API ml2s_result ml2s_publish(const ml2s_frame *frame);

/** No frame of the stream is the latest any more; its slot is free once its leases have ended. */
ML2S_API ml2s_result ml2s_unpublish(uint32_t stream);

/** Leases the latest frame of a stream that was captured after after_nanos; ML2S_TIMEOUT when there is none. */
ML2S_API ml2s_result ml2s_acquire_latest(uint32_t stream, int64_t after_nanos, ml2s_frame *frame);

/** Ends one lease. ML2S_INVALID_ARGUMENT when the slot is not leased. */
ML2S_API ml2s_result ml2s_release(uint32_t stream, uint32_t slot);

/**
 * How to reach OpenXR; before the first handle with ML2S_BACKEND_OPENXR. Either loader_path (standalone: the library
 * makes an instance and a headless session of its own), or instance, session and get_instance_proc_addr of the app,
 * which outlive every handle; then none is ever created.
 */
typedef struct ml2s_openxr {
    uint32_t struct_size;
    uint32_t reserved;
    const char *loader_path;      /**< Of the OpenXR loader, for dlopen; null with an app's own session. */
    void *java_vm;                /**< Android: JavaVM*, for xrInitializeLoaderKHR. */
    void *activity;               /**< Android: global reference of the context. */
    uint64_t instance;            /**< XrInstance */
    uint64_t session;             /**< XrSession */
    void *get_instance_proc_addr; /**< PFN_xrGetInstanceProcAddr */
} ml2s_openxr;

/**
 * Openxr is copied, the app's objects are not. NULL when the app's session is about to end: every poll of its handles
 * fails from now on; returns when the last of them is closed, or ML2S_BUSY after a second.
 */
ML2S_API ml2s_result ml2s_use_openxr(const ml2s_openxr *openxr, ml2s_error *error);

#ifdef __cplusplus
}
#endif
