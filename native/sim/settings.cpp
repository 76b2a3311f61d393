#include "settings.h"

#include <array>
#include <string>
#include <vector>

namespace ml2sim {
namespace {

using Kind = KeyTable::Kind;
using Row = KeyTable::Row;

std::vector<Row> plainRows() {
    return {
        {"seed", Kind::Whole, 1, 0, 4294967295, "chooses the path of the head, the room's pictures and all noise",
         true},
        {"loop_seconds", Kind::Whole, 4, 2, 600, "period of the head's path and of all rendered frames in seconds",
         true},
        {"still_images", Kind::Whole, 0, 0, 1, "1: each camera draws one frame and repeats it; poses go on", true},
        {"trajectory", Kind::Text, 0, 0, 0, "path of a TUM file for the head's path instead of the seed's; empty: none",
         true},
        {"tags", Kind::Text, 0, 0, 0, "the tags on the walls", true, {"4X4_50", "5X5_100", "36h11", "QR"}},
        {"tangential", Kind::Real, 1e-4, -0.01, 0.01, "p1 and p2 of the world cameras", true},
        {"image_noise", Kind::Real, 1, 0, 64, "standard deviation of pixels in grey levels that light does not add",
         true},
        {"depth_noise_m", Kind::Real, 0.002, 0, 1, "standard deviation of depth in metres", true},
        {"depth_noise_per_m", Kind::Real, 0, 0, 1, "what is added to depth_noise_m, times the square of the depth",
         true},
        {"imu_bias", Kind::Real, 0, 0, 100, "constant bias; 1: up to 0.05 m/s^2 and 0.005 rad/s on each axis"},
        {"noise", Kind::Real, 1, 0, 100,
         "times the noise of inertial units, head tracking and light in pixels, and the swing of the compute pack; 0: "
         "exact, with one exposure and no motion blur"},
        {"mounts", Kind::Whole, 0, 0, 4294967295,
         "n: draws the mounts of the inertial units on the head, and how late their stamps are; 0: as built, exact"},
        {"mltime_offset_s", Kind::Real, 7654321.012345678, 0, 1e8, "MLTime minus CLOCK_MONOTONIC when that was 0"},
        {"mltime_skew_ppm", Kind::Real, 0, -1000, 1000, "how much faster MLTime runs than CLOCK_MONOTONIC"},
        {"controller_tracked", Kind::Whole, 0, 0, 1, "1: the world cameras capture with low exposure too"},
        {"hands_visible", Kind::Whole, 3, 0, 3, "bits of the hands that are seen: 1 left, 2 right"},
        {"hidden_key_point", Kind::Whole, -1, -1, 27, "number of a key point of the hands that is not seen; -1: none"},
        {"stride_padding", Kind::Whole, 8, 0, 1024, "bytes after each row of the world cameras"},
        {"abort_on_misuse", Kind::Whole, 0, 0, 1, "1: abort at the first misuse"},
        {"clock", Kind::Text, 0, 0, 0, "manual: time goes on by ml2sim_advance only", true, {"real", "manual"}},
        {"cache", Kind::Text, 0, 0, 0, "folder that keeps rendered frames for later runs; empty: none"},
        {"app_perception", Kind::Whole, 0, 0, 1,
         "1: the app runs the perception system, which then is not the library's to start or shut down"},
        {"mains_hz", Kind::Whole, 0, 0, 60, "50 or 60: the depth camera has only the rates that this mains allows"},
        {"perception_startup_s", Kind::Real, 0, 0, 60, "seconds from MLPerceptionStartup to the first snapshot"},
        {"held", Kind::Text, 0, 0, 0, "functions of the vendor that do not return, with + between; empty: none"},
        {"assume.normal_exposure_stream", Kind::Whole, 0, 0, 1, "the stream of a world camera with normal exposure"},
        {"assume.frame_number_gaps", Kind::Whole, 1, 1, 100, "by how much a frame number is above that before it"},
        {"assume.depth_is_radial", Kind::Whole, 1, 0, 1, "0: the depth camera gives z along its axis"},
        {"assume.null_buffers", Kind::Whole, 1, 0, 1, "0: the depth camera has no flags, also for who asks for them"},
        {"assume.hand_key_points", Kind::Whole, 0, 0, 27, "by how many places the key points of a hand are shifted"},
        {"assume.magnetometer_calibrated", Kind::Real, 1, 0, 100, "times the magnetic field of the Earth"},
        {"assume.openxr_local_space", Kind::Real, 0, -100, 100, "metres by which OpenXR's LOCAL is above the world"},
        {"assume.vendor_structs", Kind::Whole, 0, 0, 64, "bytes that the eye tracker writes behind its state"},
        {"assume.tracker_layouts", Kind::Whole, 2, 0, 100, "the version of the eye tracker's state that is taken"},
        {"assume.trackers_need_head", Kind::Whole, 0, 0, 100, "how many head trackers can be open; 0: any number"},
        {"assume.depth_confidence", Kind::Whole, 1, 0, 1, "0: confidence is larger where depth is worse"},
        {"assume.camera_pose_axes", Kind::Real, 0, -180, 180,
         "degrees by which poses of world and depth cameras are turned about x"},
        {"assume.marker_axes", Kind::Real, 0, -180, 180, "degrees by which poses of markers are turned about x"},
        {"assume.marker_limit", Kind::Whole, 16, 1, 64, "how many markers are seen at a time"},
        {"assume.map_axes", Kind::Real, 0, -180, 180, "degrees by which the axes of maps are turned about x"},
        {"fault.color.permission", Kind::Whole, 0, 0, 1, "1: MLCVCameraTrackingCreate gives PermissionDenied"},
        {"fault.color.pose", Kind::Whole, 0, 0, 2,
         "MLCVCameraGetFramePose gives 1: PoseNotFound, 2: UnspecifiedFailure"},
        {"fault.gaze.permission", Kind::Whole, 0, 0, 1, "1: MLEyeTrackingCreate gives PermissionDenied"},
        {"fault.gaze.closed", Kind::Whole, 0, 0, 1, "1: the eyes are closed, nothing of them has confidence"},
        {"fault.hands.permission", Kind::Whole, 0, 0, 1, "1: MLHandTrackingCreateEx gives PermissionDenied"},
        {"fault.controller.permission", Kind::Whole, 0, 0, 1, "1: MLControllerCreateEx gives PermissionDenied"},
        {"fault.controller.tracking", Kind::Whole, 0, 0, 2,
         "1: only the rotation of the controller is known, 2: the controller is not active"},
        {"fault.input.create", Kind::Whole, 0, 0, 1, "1: MLInputCreate gives UnspecifiedFailure"},
        {"fault.input.disconnected", Kind::Whole, 0, 0, 1, "1: no controller is connected"},
        {"fault.input.unusable", Kind::Whole, 0, 0, 1, "1: the trigger is not a number"},
        {"fault.perception.startup", Kind::Whole, 0, 0, 1, "1: MLPerceptionStartup gives UnspecifiedFailure"},
        {"fault.time.convert", Kind::Whole, 0, 0, 1, "1: conversions of MLTime give UnspecifiedFailure"},
        {"fault.head.create", Kind::Whole, 0, 0, 1, "1: MLHeadTrackingCreate gives UnspecifiedFailure"},
        {"fault.head.tracking", Kind::Whole, 0, 0, 2,
         "1: relocalizing, 2: lost; poses stay where they were, snapshots have none"},
        {"fault.head.confidence", Kind::Real, 1, 0, 1, "what the tracker says while it tracks; the poses stay good"},
        {"fault.head.errors", Kind::Whole, 0, 0, 15,
         "bits that it gives as the reason: 1 unknown, 2 few features, 4 dark, 8 fast; while it does not track, 2 too"},
        {"fault.head.new_session", Kind::Whole, 0, 0, 1e6,
         "each new value begins a session: the world's origin moves to the head"},
        {"fault.snapshot.get", Kind::Whole, 0, 0, 1, "1: getting a snapshot gives UnspecifiedFailure"},
        {"fault.snapshot.predicted", Kind::Whole, 0, 0, 1,
         "1: MLPerceptionGetPredictedSnapshot gives InvalidTimestamp"},
        {"fault.pose.unusable", Kind::Whole, 0, 0, 3,
         "poses of the vendor's library are 1: all zeros, 2: not numbers, 3: with a rotation of length 0.5"},
    };
}

struct CameraFault {
    const char *what;
    double standard;
    double most;
    const char *meaning;
};

/** In the order of Fault. */
constexpr std::array kCameraFaults = {
    CameraFault{"permission", 0, 1, "1: Connect gives PermissionDenied"},
    CameraFault{"connect", 0, 1, "1: Connect gives UnspecifiedFailure"},
    CameraFault{"stalled", 0, 1, "1: no frames come, Get times out"},
    CameraFault{"get", 0, 2, "Get gives 1: UnspecifiedFailure, 2: -32, as of a service that has died"},
    CameraFault{"disconnected", 0, 1, "1: the camera goes away: waiting and later calls fail until connected anew"},
    CameraFault{"drop_every", 0, 1e6, "n: every nth frame never comes"},
    CameraFault{"frame_count", -1, 255, "frame_count says so, whatever there is"},
    CameraFault{"size", -1, 4294967295, "size of every buffer says so"},
    CameraFault{"stride", -1, 4294967295, "stride of every buffer says so"},
    CameraFault{"width", -1, 4294967295, "width of every buffer says so"},
    CameraFault{"bytes_per_pixel", -1, 4294967295, "bytes per pixel of every buffer says so"},
    CameraFault{"null_data", 0, 1, "1: data of every buffer is null"},
    CameraFault{"null_frames", 0, 1, "1: frames is null, whatever frame_count says"},
    CameraFault{"version", 0, 1, "1: Get changes the version of the caller's struct"},
    CameraFault{"id", 0, 1, "1: camera (depth: frame type) is none that the headset has"},
    CameraFault{"not_finite", 0, 1, "1: pose and focal length are not numbers"},
    CameraFault{"odd_every", 0, 1e6,
                "n: one frame of every nth capture is odd: unknown type, empty, duplicate, another size, in turn"},
};
constexpr std::array kCameraKinds = {"depth", "world", "eye"};

std::vector<Row> allRows() {
    auto rows = plainRows();
    for (const auto *camera : kCameraKinds)
        for (const auto &row : kCameraFaults)
            rows.push_back({std::string("fault.") + camera + "." + row.what, Kind::Whole, row.standard,
                            row.standard < 0 ? -1 : 0.0, row.most, row.meaning});
    return rows;
}

size_t faultIndex(CameraKind camera, Fault what) {
    return static_cast<size_t>(Key::FaultCameras) + static_cast<size_t>(camera) * kCameraFaults.size() +
           static_cast<size_t>(what);
}

} // namespace

double number(Key key) { return keys().number(static_cast<size_t>(key)); }

double fault(CameraKind camera, Fault what) { return keys().number(faultIndex(camera, what)); }

std::string text(Key key) { return keys().text(static_cast<size_t>(key)); }

KeyTable &keys() {
    static KeyTable &it = *new KeyTable(allRows()); // never destroyed: frames may be drawn while the process ends
    return it;
}

} // namespace ml2sim
