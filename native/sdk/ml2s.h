/**
 * The C interface of libml2sensors.so: the headset's pixel sensors and tracked poses.
 *
 * Kotlin calls it through JNI, C# through P/Invoke. Units are nanoseconds, metres, bytes and pixels. The axes of the
 * world and of each sensor are x right, y up, z backward (RUB). Rotations are x, y, z, w.
 *
 * **Memory.** A frame is copied once, from the vendor's memory into a *slot*. A stream has slots between ml2s_reserve
 * and ml2s_retire. The library maps a slot's memory when a frame first needs it, and unmaps it after the stream and the
 * last lease have ended. One writer fills a slot: ml2s_poll, or a caller between ml2s_take and ml2s_publish. Readers
 * then lease it, and each ends its lease with one ml2s_release. When all slots of a stream are leased, its next frame
 * is lost and reported as lost. A slow reader never stalls a camera. All functions of slots take `stream |
 * ML2S_ENCODED`, too.
 *
 * **Threads.** A handle belongs to the thread that opened it. Calls from other threads return ML2S_WRONG_THREAD.
 * ml2s_poll blocks for at most its timeout. The slot functions are thread-safe; they wait for no reader and no writer.
 *
 * **Versions.** Every structure except ml2s_plane and ml2s_memory begins with struct_size, which the caller sets to its
 * sizeof. A size smaller than that of the first version returns ML2S_INVALID_ARGUMENT. New fields are appended only.
 * Fields named reserved are 0.
 */
#pragma once

#include <stdint.h>

#include "../generated/ml2s_streams.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ML2S_API __attribute__((visibility("default")))
#define ML2S_ABI_VERSION 5u
#define ML2S_MAX_SLOTS 8u
#define ML2S_NO_SLOT UINT32_MAX
/** `stream | ML2S_ENCODED` names a stream's slots for encoded images, a second set beside those of its frames. */
#define ML2S_ENCODED 64u
/** Captures in a row without a usable frame after which ml2s_poll fails: one second of the tracking cameras. */
#define ML2S_MOST_UNUSABLE_CAPTURES 30u
#define ML2S_STREAM_BIT(stream) (UINT64_C(1) << (stream))

/** An open sensor. 0 is never valid. The value of a closed handle is not used again. */
typedef uint64_t ml2s_handle;

/** The result of a call. */
typedef enum ml2s_result {
    /** Success. */
    ML2S_OK = 0,
    /** No new data within the timeout. This is not an error. */
    ML2S_TIMEOUT = 1,
    /** Caller error: a value, size or null pointer that the call does not accept. */
    ML2S_INVALID_ARGUMENT = 2,
    /** Caller error: another thread opened the handle. */
    ML2S_WRONG_THREAD = 3,
    /** The handle was closed or never opened. */
    ML2S_CLOSED = 4,
    /** A library or symbol is missing, or the device has no such sensor; the message names it. */
    ML2S_NOT_AVAILABLE = 5,
    /** The app lacks the Android permission of the sensor. */
    ML2S_PERMISSION_DENIED = 6,
    /** All slots of the stream are leased, or it has none, or the system has no memory. */
    ML2S_ALL_SLOTS_LEASED = 7,
    /** The sensor is open already, or handles still use the OpenXR session. */
    ML2S_BUSY = 8,
    /** A call of the vendor's library failed; see vendor_code and message. */
    ML2S_VENDOR_FAILURE = 9,
    /** No pose at that time: not tracked, outside the vendor's history, or the vendor's call failed. */
    ML2S_NO_POSE = 10,
} ml2s_result;

/** Describes a failure. Set by calls that return neither ML2S_OK nor ML2S_TIMEOUT. */
typedef struct ml2s_error {
    uint32_t struct_size;
    int32_t vendor_code; /**< MLResult or XrResult; 0 if no call of the vendor's failed. */
    char message[248];   /**< Zero-terminated ASCII, such as "not available:
                            libperception.magicleap.so/MLEyeCameraConnect". */
} ml2s_error;

/** The interface through which a sensor is read. */
typedef enum ml2s_backend {
    ML2S_BACKEND_SDK = 0,    /**< The vendor's C SDK. */
    ML2S_BACKEND_OPENXR = 1, /**< OpenXR with the vendor's extensions, after ml2s_use_openxr. */
} ml2s_backend;

/** A sensor, as one handle opens it. A sensor can be open once per backend. */
typedef enum ml2s_sensor {
    ML2S_SENSOR_DEPTH = 1, /**< ML2S_STREAM_DEPTH or ML2S_STREAM_INFRA, one at a time. */
    ML2S_SENSOR_WORLD = 2, /**< Any of ML2S_STREAM_WORLD_*. */
    ML2S_SENSOR_EYE = 3,   /**< Any of ML2S_STREAM_EYE_*. */
    ML2S_SENSOR_HEAD = 4,  /**< ML2S_STREAM_HEAD_POSE, by ml2s_poll_readings. */
    ML2S_SENSOR_COLOR = 5, /**< SDK: only ml2s_color_pose. OpenXR: ML2S_STREAM_COLOR or ML2S_STREAM_MIXED_REALITY. */
    ML2S_SENSOR_GAZE = 6,  /**< ML2S_STREAM_GAZE, by ml2s_poll_readings. */
    ML2S_SENSOR_HANDS = 7, /**< ML2S_STREAM_HAND_*, by ml2s_poll_readings. */
    ML2S_SENSOR_CONTROLLER = 8,       /**< ML2S_STREAM_CONTROLLER, by ml2s_poll_readings. */
    ML2S_SENSOR_CONTROLLER_INPUT = 9, /**< ML2S_STREAM_CONTROLLER_JOY, by ml2s_poll_readings. */
    ML2S_SENSOR_MARKERS = 10,         /**< ML2S_STREAM_MARKERS, by ml2s_poll_readings; OpenXR only. */
    ML2S_SENSOR_MAP = 11,             /**< ML2S_STREAM_MAP, by ml2s_poll_readings; OpenXR only. */
} ml2s_sensor;

enum {
    ML2S_WANT_CONFIDENCE = 1u << 0, /**< Depth: fill the confidence plane. */
    ML2S_WANT_FLAGS = 1u << 1,      /**< Depth: fill the flags plane; the backend defines the bits. */
    ML2S_WANT_RADIAL = 1u << 2,     /**< Depth: distance from the camera instead of z along its optical axis. */
};

/** The camera of the marker detector. */
typedef enum ml2s_marker_camera {
    ML2S_MARKER_CAMERA_AUTO = 0,  /**< The choice of the profile. */
    ML2S_MARKER_CAMERA_WORLD = 1, /**< The world cameras. */
    ML2S_MARKER_CAMERA_RGB = 2,   /**< The RGB camera. */
} ml2s_marker_camera;

/** The configuration of a handle. The numbers of markers and maps are those of OpenXR. */
typedef struct ml2s_settings {
    uint32_t struct_size;
    uint32_t sensor;         /**< ml2s_sensor */
    uint32_t backend;        /**< ml2s_backend */
    uint32_t wants;          /**< ML2S_WANT_* */
    uint64_t streams;        /**< ML2S_STREAM_BITs to deliver; at least one. */
    uint64_t second_streams; /**< Streams that run as the device's stream 1: low exposure, short range. */
    uint32_t rate_hz;        /**< Used for depth and OpenXR; the other sensors have one rate. */
    uint32_t width;          /**< Used for OpenXR; the other sensors have one size. */
    uint32_t height;         /**< As width. */
    uint32_t reserved;
    uint32_t marker_type;       /**< Markers: XrMarkerTypeML. */
    uint32_t marker_dictionary; /**< Markers: XrMarkerArucoDictML or XrMarkerAprilTagDictML; QR has none. */
    uint32_t marker_profile;    /**< Markers: XrMarkerDetectorProfileML; not used with a camera. */
    uint32_t marker_camera;     /**< Markers: ml2s_marker_camera */
    float marker_length_m;      /**< Markers: side of the black square. */
    uint32_t map_confidence;    /**< Map: XrLocalizationMapConfidenceML; a pose with less is not tracked. */
    char map[64];               /**< Map: zero-terminated name or UUID of the one to ask for; empty: none. */
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

/** The indices of ml2s_frame.planes. */
typedef enum ml2s_plane_role {
    ML2S_PLANE_IMAGE = 0,      /**< The pixels, or one JPEG. */
    ML2S_PLANE_CONFIDENCE = 1, /**< Depth, with ML2S_WANT_CONFIDENCE: 32-bit floats. */
    ML2S_PLANE_FLAGS = 2,      /**< Depth, with ML2S_WANT_FLAGS: 32-bit words. */
    ML2S_PLANE_COUNT = 3,      /**< The number of planes. */
} ml2s_plane_role;

/** A part of a slot. size_bytes is 0 if the frame does not have the plane. */
typedef struct ml2s_plane {
    uint32_t offset_bytes; /**< From ml2s_frame.data. */
    uint32_t size_bytes;   /**< All its rows, or the JPEG. */
    uint32_t stride_bytes; /**< From one row to the next; 0 for JPEG. */
    uint32_t reserved;
} ml2s_plane;

/** One capture. Valid while the slot is leased. */
typedef struct ml2s_frame {
    uint32_t struct_size;
    uint32_t stream; /**< ml2s_stream */
    uint32_t slot;   /**< ML2S_NO_SLOT if there is no image: width is 0 if no frame was usable, and not 0 if no slot was
                        free. */
    uint32_t has;    /**< ML2S_HAS_* */
    int64_t frame_number;                /**< The device's number; a gap is a frame that the device dropped. */
    int64_t capture_nanos;               /**< CLOCK_BOOTTIME */
    int64_t device_nanos;                /**< The same instant as MLTime or XrTime. */
    uint8_t *data;                       /**< The slot's memory. */
    ml2s_plane planes[ML2S_PLANE_COUNT]; /**< By ml2s_plane_role. */
    uint32_t width;                      /**< Pixels per row. */
    uint32_t height;                     /**< Rows. */
    float rotation[4];                   /**< Rotation of the camera in the world: x, y, z, w. */
    float position[3];                   /**< Position of the camera in the world. */
    uint32_t lens;                       /**< ml2s_lens */
    double focal_length[2];              /**< x, y. */
    double principal_point[2];           /**< x, y, from the top left. */
    double distortion[6];                /**< Coefficients of the lens model; unused ones are 0. */
    int64_t exposure_nanos;              /**< Exposure time. */
    uint32_t analog_gain;                /**< The device's own unit. */
    uint32_t digital_gain;               /**< The device's own unit. */
    uint32_t illumination;               /**< 1 if the illuminator of the depth camera was on. */
    uint32_t skipped;                    /**< Number of odd frames that were skipped; see ml2s_poll. */
    float head_rotation[4];              /**< The head in the world at the capture: x, y, z, w. */
    float head_position[3];              /**< The head in the world at the capture, in m. */
    uint32_t reserved;
} ml2s_frame;

enum {
    ML2S_TRACKING_LOST = 1u << 0,            /**< Tracking is lost. */
    ML2S_TRACKING_RECOVERED = 1u << 1,       /**< Tracking is back, in the same world. */
    ML2S_TRACKING_RECOVERY_FAILED = 1u << 2, /**< The old world cannot be recovered. */
    ML2S_TRACKING_NEW_SESSION = 1u << 3,     /**< Poses are in a new world. */
};

/** The indices of ml2s_reading.values for ML2S_STREAM_CONTROLLER_JOY. */
typedef enum ml2s_input {
    ML2S_INPUT_TRIGGER = 0, /**< 0: released, 1: pulled. */
    ML2S_INPUT_BUMPER = 1,  /**< 1: pressed. */
    ML2S_INPUT_MENU = 2,    /**< 1: pressed. */
    ML2S_INPUT_TOUCHED = 3, /**< 1: a finger is on the touchpad. Without one, the following are 0. */
    ML2S_INPUT_TOUCH_X = 4, /**< Place to the right: -1 to 1. */
    ML2S_INPUT_TOUCH_Y = 5, /**< Place away from the user: -1 to 1. */
    ML2S_INPUT_FORCE = 6,   /**< Pressure, 0 to 1. */
    ML2S_INPUT_COUNT = 7,   /**< The number of values. */
} ml2s_input;

/** The indices of ml2s_reading.values for ML2S_STREAM_MARKERS. */
typedef enum ml2s_marker_value {
    ML2S_MARKER_LENGTH_M = 0,             /**< Side of the black square. */
    ML2S_MARKER_REPROJECTION_ERROR_M = 1, /**< Distance of its corners from where its pose puts them. */
} ml2s_marker_value;

/** The indices of ml2s_reading.values for ML2S_STREAM_MAP. */
typedef enum ml2s_map_value {
    ML2S_MAP_STATE = 0,      /**< XrLocalizationMapStateML; -1 until the device has said it. */
    ML2S_MAP_CONFIDENCE = 1, /**< XrLocalizationMapConfidenceML */
    ML2S_MAP_ERRORS = 2,     /**< Bits of XrLocalizationMapErrorFlagsML. */
    ML2S_MAP_TYPE = 3,       /**< XrLocalizationMapTypeML */
} ml2s_map_value;

/** The indices of ml2s_reading.values for ML2S_STREAM_HEAD_POSE. */
typedef enum ml2s_head_value {
    ML2S_HEAD_STATUS = 0,     /**< MLHeadTrackingStatus; -1 with ML2S_BACKEND_OPENXR, which does not say it. */
    ML2S_HEAD_CONFIDENCE = 1, /**< 0 to 1. */
    ML2S_HEAD_ERRORS = 2,     /**< Bits of MLHeadTrackingErrorFlag. */
} ml2s_head_value;

/** The indices of ml2s_reading.values for ML2S_STREAM_GAZE by OpenXR. A value is -1 until the device has said it. */
typedef enum ml2s_gaze_value {
    ML2S_GAZE_FIT = 0,         /**< XrHeadsetFitStatusML */
    ML2S_GAZE_CALIBRATION = 1, /**< XrEyeCalibrationStatusML */
} ml2s_gaze_value;

/** A reading of a sensor without images: the state of one thing at one instant. */
typedef struct ml2s_reading {
    uint32_t struct_size;
    uint32_t stream;       /**< ml2s_stream */
    int64_t capture_nanos; /**< CLOCK_BOOTTIME of the instant. */
    int64_t device_nanos;  /**< The same instant as MLTime or XrTime. */
    uint64_t id;           /**< A joint by XrHandJointEXT, or the number of a marker; else 0. */
    float rotation[4];     /**< In the world: x, y, z, w. */
    float position[3];     /**< In the world. */
    uint32_t
        is_tracked;  /**< 0: not seen or not connected; rotation and position are not valid, nor are values of input. */
    uint32_t events; /**< ML2S_TRACKING_* since the last poll. */
    float values[ML2S_INPUT_COUNT]; /**< By the enumeration of the stream; 0 for streams without one. */
    char name[256];                 /**< Zero-terminated UTF-8: the content of a QR code, or a map; else empty. */
} ml2s_reading;

/** A piece of memory. That of a slot begins at a page. */
typedef struct ml2s_memory {
    uint8_t *data;       /**< The first byte. */
    uint64_t size_bytes; /**< Size of the memory. */
} ml2s_memory;

/** Returns the library's ML2S_ABI_VERSION, which increases when older callers no longer work. */
ML2S_API uint32_t ml2s_abi_version(void);

/** Returns the current CLOCK_BOOTTIME. */
ML2S_API int64_t ml2s_now(void);

/** Converts an MLTime to CLOCK_BOOTTIME. XrTime is MLTime on this device. Thread-safe. */
ML2S_API ml2s_result ml2s_boottime_of(int64_t device_nanos, int64_t *capture_nanos, ml2s_error *error);

/** Checks that the library and symbols of a sensor exist. Does not access the device. Thread-safe. */
ML2S_API ml2s_result ml2s_check(uint32_t sensor, uint32_t backend, ml2s_error *error);

/** Opens a sensor and starts its streams. In this and all other functions, error may be null. */
ML2S_API ml2s_result ml2s_open(const ml2s_settings *settings, ml2s_handle *out, ml2s_error *error);

/**
 * Changes streams or values of an open sensor. After a failure the previous ones continue. If the device does not start
 * them again either, each ml2s_poll fails until the sensor is closed and opened again.
 */
ML2S_API ml2s_result ml2s_configure(ml2s_handle handle, const ml2s_settings *settings, ml2s_error *error);

/**
 * Waits for the next capture and returns its frames, at most one per stream. Each frame is leased to the caller, or
 * lost: see ml2s_frame.slot. capacity should be at least the number of streams; further frames are lost.
 *
 * An odd frame is skipped and counted in ml2s_frame.skipped of its stream: its image lies outside its memory, it has no
 * time, the camera is unknown, the camera has a second frame in the capture, or the size has changed. After
 * ML2S_MOST_UNUSABLE_CAPTURES captures in a row without a usable frame the poll fails; the message describes the last
 * one.
 */
ML2S_API ml2s_result ml2s_poll(ml2s_handle handle, uint64_t timeout_nanos, ml2s_frame *frames, uint32_t capacity,
                               uint32_t *count, ml2s_error *error);

/**
 * Returns the current readings: one for HEAD, GAZE, CONTROLLER and CONTROLLER_INPUT, and 26 per hand for HANDS, in the
 * order of XrHandJointEXT. Each can be untracked. What exceeds capacity is left out.
 *
 * MARKERS has up to 16, all tracked, each with another id or name. Axes of ArUco and QR are x right, y up, z out of the
 * face; of AprilTag x right, y down, z into the face. A QR code of more than 255 bytes is left out.
 *
 * MAP has the origin of the map in which the headset is localized. It is tracked while that is the map asked for, with
 * enough confidence; its values are valid all the time. Its name is the map's UUID, a space and the map's name.
 */
ML2S_API ml2s_result ml2s_poll_readings(ml2s_handle handle, ml2s_reading *readings, uint32_t capacity, uint32_t *count,
                                        ml2s_error *error);

/** Returns the pose of the colour camera at device_nanos. The device keeps a short history: call it for each new frame.
 */
ML2S_API ml2s_result ml2s_color_pose(ml2s_handle handle, int64_t device_nanos, ml2s_reading *pose, ml2s_error *error);

/**
 * Returns the rates in Hz that the device offers for the streams of an open handle, up to capacity. Only DEPTH with
 * ML2S_BACKEND_SDK has a list: 50 Hz mains light excludes 30 and 60 Hz, 60 Hz mains light excludes 25 and 50 Hz.
 */
ML2S_API ml2s_result ml2s_list_rates(ml2s_handle handle, uint32_t *rates_hz, uint32_t capacity, uint32_t *count,
                                     ml2s_error *error);

/** Closes the handle, also if it returns a failure. Leased slots stay valid. */
ML2S_API ml2s_result ml2s_close(ml2s_handle handle, ml2s_error *error);

/** Gives a stream ML2S_MAX_SLOTS slots, if it has none yet. Each call is ended by one ml2s_retire. */
ML2S_API ml2s_result ml2s_reserve(uint32_t stream);

/** Ends one ml2s_reserve. The last one withdraws the latest frame; each slot ends with its last lease. */
ML2S_API ml2s_result ml2s_retire(uint32_t stream);

/**
 * Takes a free slot for writing, with memory of size_bytes. Call ml2s_publish and then ml2s_release, or only
 * ml2s_release to discard the frame. Memory of another size, which no frame uses, is unmapped.
 */
ML2S_API ml2s_result ml2s_take(uint32_t stream, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory);

/** Publishes the frame in the taken slot frame->slot as the latest of its stream. The writer keeps its lease. */
ML2S_API ml2s_result ml2s_publish(const ml2s_frame *frame);

/** Withdraws the latest frame of a stream. Its slot is free when all leases have ended. */
ML2S_API ml2s_result ml2s_unpublish(uint32_t stream);

/** Leases the latest frame of a stream, or returns ML2S_TIMEOUT if none was captured after after_nanos. */
ML2S_API ml2s_result ml2s_acquire_latest(uint32_t stream, int64_t after_nanos, ml2s_frame *frame);

/** Ends one lease. Returns ML2S_INVALID_ARGUMENT if the slot is not leased. */
ML2S_API ml2s_result ml2s_release(uint32_t stream, uint32_t slot);

/** Inboxes that can be open, and messages that can wait in one. */
#define ML2S_MOST_INBOXES 160u
#define ML2S_MOST_INBOX_DEPTH 100u

/** A message in an inbox. Valid while its slot is leased. */
typedef struct ml2s_message {
    uint32_t struct_size;
    uint32_t slot;           /**< For ml2s_inbox_release. */
    uint8_t *data;           /**< The first byte. */
    uint64_t size_bytes;     /**< Size of the message, which its memory may exceed. */
    int64_t published_nanos; /**< When it was published, in ROS time; 0 if unknown. */
    uint32_t number;         /**< The number of the message in its topic. */
    uint32_t reserved;
    uint64_t left_out; /**< Messages that the inbox has dropped so far, because newer ones took their place. */
} ml2s_message;

/**
 * Opens an inbox: a queue of messages from one writer to one reader, which may be different threads. It holds the
 * newest depth messages, 1 to ML2S_MOST_INBOX_DEPTH, beside the one that the reader leases. Its memory grows to the
 * largest messages and is used again. What an app sends waits in an inbox, too: the app writes, with the time of
 * capture on CLOCK_BOOTTIME as published_nanos. All functions of inboxes are thread-safe; only ml2s_inbox_wait waits.
 */
ML2S_API ml2s_result ml2s_inbox_open(uint32_t depth, uint32_t *inbox);

/** Takes a slot for writing a message of size_bytes. End it by one ml2s_inbox_add or ml2s_inbox_release. */
ML2S_API ml2s_result ml2s_inbox_take(uint32_t inbox, uint64_t size_bytes, uint32_t *slot, ml2s_memory *memory);

/** Appends the message in the taken slot message->slot. The oldest is dropped if more than depth wait. */
ML2S_API ml2s_result ml2s_inbox_add(uint32_t inbox, const ml2s_message *message);

/** Waits without a limit until a message waits. Returns ML2S_CLOSED once the inbox is closed. */
ML2S_API ml2s_result ml2s_inbox_wait(uint32_t inbox);

/** Leases the oldest message, or returns ML2S_TIMEOUT if none waits. End it by one ml2s_inbox_release. */
ML2S_API ml2s_result ml2s_inbox_acquire(uint32_t inbox, ml2s_message *message);

/** Ends a lease, also of an inbox that was closed. Returns ML2S_INVALID_ARGUMENT if the slot is not leased. */
ML2S_API ml2s_result ml2s_inbox_release(uint32_t inbox, uint32_t slot);

/** Drops all messages that wait but the newest. */
ML2S_API ml2s_result ml2s_inbox_skip(uint32_t inbox);

/** Closes an inbox. What waits is dropped; a leased message stays valid until its release. */
ML2S_API ml2s_result ml2s_inbox_close(uint32_t inbox);

/**
 * Selects the OpenXR session. Standalone: set loader_path; the library creates an instance and a headless session. With
 * an app's session: set instance, session and get_instance_proc_addr, which must outlive every handle.
 */
typedef struct ml2s_openxr {
    uint32_t struct_size;
    uint32_t reserved;
    const char *loader_path;      /**< Path of the OpenXR loader for dlopen; null with an app's session. */
    void *java_vm;                /**< Android: JavaVM*, for xrInitializeLoaderKHR. */
    void *activity;               /**< Android: global reference to the context. */
    uint64_t instance;            /**< XrInstance */
    uint64_t session;             /**< XrSession */
    void *get_instance_proc_addr; /**< PFN_xrGetInstanceProcAddr */
} ml2s_openxr;

/**
 * Sets how OpenXR is reached. Call it before the first handle with ML2S_BACKEND_OPENXR; openxr is copied. Pass NULL
 * before the app's session ends: polls of its handles then fail, and the call returns when the last handle is closed,
 * or ML2S_BUSY after 1 s.
 */
ML2S_API ml2s_result ml2s_use_openxr(const ml2s_openxr *openxr, ml2s_error *error);

/** The codecs of ml2s_encode. */
typedef enum ml2s_codec {
    /** 8-bit grey pixels to a baseline JPEG of one component; quality is 1 to 100, with libjpeg's tables. */
    ML2S_CODEC_GREY_JPEG = 1,
    /**
     * 32-bit floats in metres to the data of ROS's `16UC1; compressedDepth rvl`. Distances are rounded to millimetres;
     * NaN, and what rounds to no number from 1 to 65535, becomes 0. quality is 0.
     */
    ML2S_CODEC_DEPTH_RVL = 2,
} ml2s_codec;

/** An image to encode. */
typedef struct ml2s_image {
    uint32_t struct_size;
    uint32_t codec;        /**< ml2s_codec */
    uint32_t quality;      /**< See ml2s_codec. */
    uint32_t width;        /**< Pixels per row, 1 to 65535. */
    uint32_t height;       /**< Rows, 1 to 65535. */
    uint32_t stride_bytes; /**< From one row to the next; for floats a multiple of 4. */
    const uint8_t *data;   /**< The first row; for floats aligned to 4 bytes. Owned by the caller. */
    uint64_t size_bytes;   /**< The size of data; nothing beyond is read. */
} ml2s_image;

/**
 * Returns a size that no image with codec, width and height of image exceeds when it is encoded, whatever it shows; the
 * other fields are not used. It is several times the usual size. Memory that is mapped for it but never written costs
 * no page. Thread-safe.
 */
ML2S_API ml2s_result ml2s_most_encoded_bytes(const ml2s_image *image, uint64_t *size_bytes, ml2s_error *error);

/**
 * Encodes an image into output and returns the number of bytes written. output must not overlap the image, has at least
 * the size of ml2s_most_encoded_bytes and needs no alignment. Uses no other memory than these and 4 KiB of stack.
 * Thread-safe; it does not block. After a failure, ML2S_INVALID_ARGUMENT, output is unchanged.
 */
ML2S_API ml2s_result ml2s_encode(const ml2s_image *image, ml2s_memory output, uint64_t *size_bytes, ml2s_error *error);

#ifdef __cplusplus
}
#endif
