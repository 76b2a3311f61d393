// ml2sim_true_pose, ml2sim_true_head, ml2sim_reported_head, ml2sim_landmarks, ml2sim_mounts: the ground truth for
// tests.
#include <cstdarg>
#include <cstdio>
#include <string>

#include "clock.h"
#include "head_path.h"
#include "imperfections.h"
#include "ml2sim.h"
#include "tracking.h"

namespace ml2sim {
namespace {

/** The camera of each ml2sim_camera. */
constexpr Camera kCameras[] = {Camera::WorldLeft, Camera::WorldRight, Camera::WorldCenter, Camera::Depth,
                               Camera::Color};

void write(const Pose &pose, ml2sim_pose *out) {
    *out = {{pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w},
            {pose.position.x, pose.position.y, pose.position.z}};
}

std::string json(Vec3 v) {
    char text[96];
    std::snprintf(text, sizeof text, "[%.9g, %.9g, %.9g]", v.x, v.y, v.z);
    return text;
}

std::string poseJson(const char *name, const Pose &pose) {
    const auto &q = pose.rotation;
    char rotation[128];
    std::snprintf(rotation, sizeof rotation, "[%.12g, %.12g, %.12g, %.12g]", q.x, q.y, q.z, q.w);
    return std::string("\"") + name + "\": {\"rotation\": " + rotation + ", \"position\": " + json(pose.position);
}

std::string json(const char *name, const Pose &pose) { return poseJson(name, pose) + "}"; }

std::string json(const char *name, Imu unit) {
    char late[48];
    std::snprintf(late, sizeof late, ", \"late_s\": %.9f}", static_cast<double>(lateNanos(unit)) / kSecond);
    return poseJson(name, mountInHead(unit)) + late;
}

/** Writes the tags. Each has four consecutive landmarks. */
std::string tagsJson(const Scene &scene) {
    std::string out;
    int open = -1;
    for (const auto &landmark : scene.landmarks()) {
        if (landmark.tag != open) {
            out += (open < 0 ? "" : "]}, ") + ("{\"id\": " + std::to_string(landmark.tag)) + ", \"corners\": [";
            open = landmark.tag;
        } else {
            out += ", ";
        }
        out += json(pointInWorld(landmark.position));
    }
    return open < 0 ? out : out + "]}";
}

std::string wallsJson(const Scene &scene) {
    constexpr size_t kWalls = 6;
    std::string out;
    for (size_t i = 0; i < kWalls; i++) {
        const auto &wall = scene.planes()[i];
        const Vec3 normal = rotate(inWorld({}).rotation, wall.normal);
        char offset[32];
        std::snprintf(offset, sizeof offset, "%.9g", dot(normal, pointInWorld(wall.origin)));
        out += (i == 0 ? "" : ", ") + ("{\"normal\": " + json(normal)) + ", \"offset_m\": " + offset + "}";
    }
    return out;
}

} // namespace
} // namespace ml2sim

using namespace ml2sim;

int32_t ml2sim_true_pose(uint32_t camera, int64_t mltime_nanos, ml2sim_pose *out) {
    if (camera >= ML2SIM_CAMERA_COUNT)
        return -1;
    write(compose(trueHead(mltime_nanos), mount(kCameras[camera])), out);
    return 0;
}

void ml2sim_true_head(int64_t mltime_nanos, ml2sim_pose *out) { write(trueHead(mltime_nanos), out); }

void ml2sim_reported_head(int64_t mltime_nanos, ml2sim_pose *out) { write(reportedHead(mltime_nanos), out); }

const char *ml2sim_landmarks(void) {
    thread_local std::string text;
    const auto room = HeadPath::scene();
    text = "{\"tags\": [" + tagsJson(*room) + "], \"walls\": [" + wallsJson(*room) + "]}";
    return text.c_str();
}

const char *ml2sim_mounts(void) {
    thread_local std::string text;
    text = "{" + json("world_left", mount(Camera::WorldLeft)) + ", " + json("world_right", mount(Camera::WorldRight)) +
           ", " + json("world_center", mount(Camera::WorldCenter)) + ", " + json("depth", mount(Camera::Depth)) + ", " +
           json("color", mount(Camera::Color)) + ", " + json("imu_left", Imu::Left) + ", " +
           json("imu_right", Imu::Right) + ", " + json("imu_compute_pack", Imu::ComputePack) + "}";
    return text.c_str();
}
