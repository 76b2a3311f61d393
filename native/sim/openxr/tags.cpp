#include "tags.h"

#include "../head_path.h"
#include "../tracking.h"
#include "runtime.h"

namespace ml2sim::xr {
namespace {

/** As the sides of the cards are seen: at most so far from the front. */
constexpr double kMostAslant_rad = 1.2;

/** The four corners of a tag in the scene, clockwise from its top left. */
using Square = std::vector<Vec3>;

Square cornersOf(const Scene &scene, int tag) {
    Square corners;
    for (const auto &landmark : scene.landmarks())
        if (landmark.tag == tag)
            corners.push_back(landmark.position);
    return corners;
}

Vec3 centerOf(const Square &corners) { return 0.5 * (corners[0] + corners[2]); }

Vec3 normalOf(const Square &corners) { return normalized(cross(corners[1] - corners[0], corners[0] - corners[3])); }

template <class Lens> bool isInImage(const Lens &lens, const Pose &camera, const Square &corners) {
    const auto back = inverse(camera);
    Pixel last{};
    for (size_t i = 0; i <= corners.size(); i++) {
        const auto pixel = lens.project(transform(back, corners[i % corners.size()]));
        if (!pixel || pixel->u < 0 || pixel->v < 0 || pixel->u > lens.width - 1 || pixel->v > lens.height - 1)
            return false;
        if (i > 0 && std::hypot(pixel->u - last.u, pixel->v - last.v) < runtime().keys.whole("markers.least_pixels"))
            return false;
        last = *pixel;
    }
    return true;
}

bool isClear(const Scene &scene, Vec3 camera, const Square &corners) {
    const Vec3 way = camera - centerOf(corners);
    if (dot(normalized(way), normalOf(corners)) < std::cos(kMostAslant_rad))
        return false;
    for (const auto &corner : corners)
        if (!scene.isClear(camera, corner))
            return false;
    return true;
}

bool isSeen(const Scene &scene, const Pose &head, Camera camera, const Square &corners) {
    const auto place = compose(head, mount(camera));
    return isClear(scene, place.position, corners) &&
           (camera == Camera::Color ? isInImage(colorLens(1920, 1080), place, corners)
                                    : isInImage(worldLens(), place, corners));
}

} // namespace

size_t mostSeen() { return static_cast<size_t>(ml2sim::number(Key::AssumeMarkerLimit)); }

std::vector<int> visibleTags(bool byColorCamera, int64_t mltime) {
    const auto scene = HeadPath::scene();
    const auto head = HeadPath::current()->at(mltime).head;
    const std::vector<Camera> cameras =
        byColorCamera ? std::vector<Camera>{Camera::Color}
                      : std::vector<Camera>{Camera::WorldLeft, Camera::WorldCenter, Camera::WorldRight};
    std::vector<int> tags;
    for (const auto &landmark : scene->landmarks()) {
        if (landmark.corner != 0 || tags.size() == mostSeen())
            continue;
        const auto corners = cornersOf(*scene, landmark.tag);
        for (const auto camera : cameras)
            if (isSeen(*scene, head, camera, corners)) {
                tags.push_back(landmark.tag);
                break;
            }
    }
    return tags;
}

Pose seenFrom(int tag, int64_t mltime) {
    const auto corners = cornersOf(*HeadPath::scene(), tag);
    const Vec3 out = normalOf(corners);
    const auto rotation = // all hang upright
        Quaternion::about({0, 1, 0}, std::atan2(out.x, out.z)) * aboutX(ml2sim::number(Key::AssumeMarkerAxes));
    const auto head = HeadPath::current()->at(mltime).head;
    return compose(reportedHead(mltime), compose(inverse(head), {rotation, centerOf(corners)}));
}

std::string textOfTag(int tag) { return "ml2-" + std::to_string(tag); }

} // namespace ml2sim::xr
