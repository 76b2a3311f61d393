/**
 * Writes what the cameras see along the default trajectory, and the truth about it, for checks by other programs:
 * `scene_shots FOLDER TANGENTIAL [POSES]` makes <n>_<camera>.pgm or .ppm (the depth camera's infrared image as .pgm)
 * and truth.json. `scene_shots FOLDER TANGENTIAL POSES 1` shows each tag of ArUco 5X5 from near instead, 2 AprilTags, 3
 * QR codes.
 */
#include "render.h"
#include "trajectory.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

using namespace ml2sim;

namespace {

constexpr double kLoop_s = 10;
constexpr int kAround =
    12; ///< World images in all directions, from two places, so that no box hides a fiducial from both.

std::ostream &operator<<(std::ostream &out, const Pose &pose) {
    const Quaternion q = pose.rotation;
    const Vec3 p = pose.position;
    return out << "[" << q.x << "," << q.y << "," << q.z << "," << q.w << "," << p.x << "," << p.y << "," << p.z << "]";
}

std::ostream &operator<<(std::ostream &out, const Sensor &lens) {
    return out << "\"f\":[" << lens.fx << "," << lens.fy << "],\"c\":[" << lens.cx << "," << lens.cy << "]";
}

class Shots {
  public:
    Shots(const std::string &folder, double tangential, TagKind tags)
        : folder_(folder), scene_(1, tags), world_(worldLens(tangential, -tangential / 2)),
          truth_(folder + "/truth.json") {
        truth_.precision(17);
    }

    void take(int poses, bool isNear) {
        const Trajectory trajectory = Trajectory::looped(1, kLoop_s);
        truth_ << "{\"landmarks\":[";
        const char *comma = "";
        for (const Landmark &l : scene_.landmarks()) {
            truth_ << comma << "[" << l.tag << "," << l.corner << "," << l.position.x << "," << l.position.y << ","
                   << l.position.z << "]";
            comma = ",";
        }
        truth_ << "],\"shots\":[";
        for (int n = 0; n < poses && !isNear; n++)
            shoot(n, trajectory.at(kLoop_s * n / poses).head);
        for (size_t n = 0; n < scene_.landmarks().size() && isNear; n += 4)
            approach(&scene_.landmarks()[n]);
        for (int n = 0; n < kAround && !isNear; n++) {
            const Vec3 place = n % 2 == 0 ? Vec3{0.2, 0, 0.4} : Vec3{-0.2, 0.9, -0.4};
            takeWorld(n, "around", {Quaternion::about({0, 1, 0}, 2 * M_PI * n / kAround), place});
        }
        truth_ << "]}\n";
    }

  private:
    /** Looks at the centre of a tag from two places, 0.6 to 1.6 m before it and a little aside. */
    void approach(const Landmark *corners) {
        const int tag = corners->tag;
        const Vec3 center = 0.5 * (corners[0].position + corners[2].position);
        const Vec3 right = normalized(corners[1].position - corners[0].position);
        const Vec3 down = normalized(corners[3].position - corners[0].position);
        for (const double nearest : {0.6, 1.0}) {
            const Vec3 way =
                (nearest + 0.1 * (tag % 7)) * cross(down, right) + (0.15 * (tag % 5 - 2)) * right + 0.2 * down;
            const Vec3 back = normalized(way);
            const auto turned = Quaternion::about({0, 1, 0}, std::atan2(back.x, back.z)) *
                                Quaternion::about({1, 0, 0}, -std::asin(back.y));
            takeWorld(tag, nearest < 1 ? "near" : "farther", {turned, center + way});
        }
    }

    void shoot(int n, const Pose &head) {
        takeWorld(n, "world_left", compose(head, mount(Camera::WorldLeft)));
        takeWorld(n, "world_center", compose(head, mount(Camera::WorldCenter)));
        takeWorld(n, "world_right", compose(head, mount(Camera::WorldRight)));
        takeDepth(n, compose(head, mount(Camera::Depth)));
        takeColor(n, compose(head, mount(Camera::Color)));
    }

    void takeWorld(int n, const std::string &camera, const Pose &pose) {
        std::vector<uint8_t> grey(size_t(world_.width) * world_.height);
        renderWorld(scene_, world_rays_, pose, grey.data(), world_.width);
        save(n, camera, pose, "P5", grey, world_);
        truth_ << world_ << ",\"fisheye\":[" << world_.k[0] << "," << world_.k[1] << "," << world_.k[2] << ","
               << world_.k[3] << "," << world_.p1 << "," << world_.p2 << "]}";
    }

    void takeDepth(int n, const Pose &pose) {
        std::vector<float> raw(size_t(depth_.width) * depth_.height);
        DepthImages images;
        images.raw = raw.data();
        images.stride_bytes = depth_.width * sizeof(float);
        renderDepth(scene_, depth_rays_, pose, kLongRange, images);
        std::vector<uint8_t> grey(raw.size());
        for (size_t i = 0; i < raw.size(); i++)
            grey[i] = uint8_t(std::min(raw[i] * 1.5f, 255.0f));
        save(n, "depth", pose, "P5", grey, depth_);
        putPlumbBob(depth_);
    }

    void takeColor(int n, const Pose &pose) {
        std::vector<uint8_t> rgb(size_t(3) * color_.width * color_.height);
        renderColor(scene_, color_rays_, pose, false, rgb.data(), 3 * color_.width);
        save(n, "color", pose, "P6", rgb, color_);
        putPlumbBob(color_);
    }

    void save(int n, const std::string &camera, const Pose &pose, const char *format,
              const std::vector<uint8_t> &pixels, const Sensor &sensor) {
        const std::string name = std::to_string(n) + "_" + camera + (format[1] == '5' ? ".pgm" : ".ppm");
        std::ofstream file(folder_ + "/" + name, std::ios::binary);
        file << format << "\n" << sensor.width << " " << sensor.height << "\n255\n";
        file.write(reinterpret_cast<const char *>(pixels.data()), std::streamsize(pixels.size()));
        truth_ << comma_ << "{\"image\":\"" << name << "\",\"camera\":\"" << camera << "\",\"pose\":" << pose << ",";
        comma_ = ",";
        putClear(pose.position);
    }

    /** The landmarks, as places in the list of all, that the camera sees with a marker's cell around them. */
    void putClear(Vec3 camera) {
        const std::vector<Landmark> &all = scene_.landmarks();
        truth_ << "\"clear\":[";
        const char *comma = "";
        for (size_t i = 0; i < all.size(); i++) {
            const Vec3 corner = all[i].position, next = all[i / 4 * 4 + (i + 1) % 4].position,
                       last = all[i / 4 * 4 + (i + 3) % 4].position;
            bool isClear = true;
            for (int n = 0; n < 9; n++) {
                const Vec3 aside = (n % 3 - 1) / 6.0 * (next - corner) + (n / 3 - 1) / 6.0 * (last - corner);
                isClear = isClear && scene_.isClear(camera, corner + aside);
            }
            if (!isClear)
                continue;
            truth_ << comma << i;
            comma = ",";
        }
        truth_ << "],";
    }

    void putPlumbBob(const PlumbBob &lens) {
        truth_ << lens << ",\"plumb_bob\":[" << lens.k1 << "," << lens.k2 << "," << lens.p1 << "," << lens.p2 << ","
               << lens.k3 << "]}";
    }

    std::string folder_;
    Scene scene_;
    FisheyeTangential world_;
    PlumbBob depth_ = depthLens();
    PlumbBob color_ = colorLens(1920, 1080);
    RayTable world_rays_{world_};
    RayTable depth_rays_{depth_};
    RayTable color_rays_{color_};
    std::ofstream truth_;
    const char *comma_ = "";
};

} // namespace

int main(int count, char **arguments) {
    if (count < 3) {
        std::fprintf(stderr, "scene_shots FOLDER TANGENTIAL [POSES [TAGS]]\n");
        return 2;
    }
    const int tags = count > 4 ? std::atoi(arguments[4]) : 0;
    Shots shots(arguments[1], std::atof(arguments[2]), static_cast<TagKind>(tags));
    shots.take(count > 3 ? std::atoi(arguments[3]) : 10, tags != 0);
}
