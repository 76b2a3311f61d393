/** Prints the processor time that each camera's picture takes, milliseconds: the least of many along a trajectory. */
#include "render.h"
#include "trajectory.h"

#include <algorithm>
#include <cstdio>
#include <ctime>

using namespace ml2sim;

namespace {

constexpr int kFrames = 40;

double processorSeconds() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

template <class Work> void measure(const char *name, int times, Work work) {
    double least_s = 1e9;
    for (int n = 0; n < times; n++) {
        const double start_s = processorSeconds();
        work(n);
        least_s = std::min(least_s, processorSeconds() - start_s);
    }
    std::printf("%-34s %7.1f\n", name, 1e3 * least_s);
}

} // namespace

int main() {
    measure("scene", 1, [](int) { Scene{}; });
    measure("ray table of a world camera", 1, [](int) { RayTable{worldLens()}; });
    const Scene scene;
    const Trajectory trajectory = Trajectory::looped(1, 10);
    const RayTable world(worldLens()), depth(depthLens()), color(colorLens(1920, 1080));
    const auto pose = [&](Camera camera, int n) {
        return compose(trajectory.at(10.0 * n / kFrames).head, mount(camera));
    };
    std::vector<uint8_t> pixels(1920 * 1080 * 3);
    measure("world 1016 x 1016", kFrames,
            [&](int n) { renderWorld(scene, world, pose(Camera::WorldCenter, n), pixels.data(), 1016); });
    measure("world 1016 x 1016, noise and blur", kFrames, [&](int n) {
        renderWorld(scene, world, pose(Camera::WorldCenter, n), pixels.data(), 1016,
                    {1, {2, 1, uint64_t(n), 0, 0.1f}, {0.01, 0, 0}});
    });
    std::vector<float> values(4 * 544 * 480);
    std::vector<uint32_t> flags(544 * 480);
    DepthImages images;
    images.distance_m = &values[0];
    images.confidence = &values[544 * 480];
    images.raw = &values[2 * 544 * 480];
    images.ambient_raw = &values[3 * 544 * 480];
    images.flags = flags.data();
    images.stride_bytes = 544 * sizeof(float);
    measure("depth 544 x 480, all five images", kFrames,
            [&](int n) { renderDepth(scene, depth, pose(Camera::Depth, n), kLongRange, images); });
    for (const bool hologram : {false, true}) {
        measure(hologram ? "colour 1920 x 1080, hologram" : "colour 1920 x 1080", kFrames,
                [&](int n) { renderColor(scene, color, pose(Camera::Color, n), hologram, pixels.data(), 1920 * 3); });
    }
    measure("eye 400 x 400", kFrames,
            [&](int n) { renderEye(EyeCamera::LeftNasal, double(n) / kFrames, pixels.data(), kEyeWidth); });
}
