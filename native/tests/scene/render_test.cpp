#include "render.h"
#include "trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

using namespace ml2sim;

namespace {

const Scene &room() {
    static const Scene scene;
    return scene;
}

const RayTable &depthRays() {
    static const RayTable rays(depthLens());
    return rays;
}

/** A small world camera: enough for what does not depend on its size. */
const RayTable &smallRays() {
    static const RayTable rays(FisheyeTangential{{120, 100, 68, 68, 60, 50}, {0.012, -0.006, 0.002, -0.0004}, 0, 0});
    return rays;
}

struct DepthFrame {
    explicit DepthFrame(const Pose &camera, DepthRange range = kLongRange, Noise noise = {})
        : distance_m(544 * 480), confidence(544 * 480), raw(544 * 480), ambient(544 * 480), flags(544 * 480) {
        DepthImages images;
        images.distance_m = distance_m.data();
        images.confidence = confidence.data();
        images.flags = flags.data();
        images.raw = raw.data();
        images.ambient_raw = ambient.data();
        images.stride_bytes = 544 * 4;
        renderDepth(room(), depthRays(), camera, range, images, noise);
    }

    size_t count(uint32_t wanted) const { return size_t(std::count(flags.begin(), flags.end(), wanted)); }

    std::vector<float> distance_m, confidence, raw, ambient;
    std::vector<uint32_t> flags;
};

Pose depthPose(double seconds) { return compose(Trajectory::looped(1, 10).at(seconds).head, mount(Camera::Depth)); }

Pose facingFrontWall(double metres) { return {{}, {0, 0.3, kRoomLow.z + metres}}; }

/** The least distance of a point to one of the rectangles of the room, metres. */
double distanceToSurfaces(Vec3 point) {
    double least = 1e9;
    for (const Plane &plane : room().planes()) {
        const Vec3 from = point - plane.origin;
        const double across = dot(from, plane.across), down = dot(from, plane.down);
        const bool isWithin =
            across > -1e-4 && across < plane.width_m + 1e-4 && down > -1e-4 && down < plane.height_m + 1e-4;
        if (isWithin)
            least = std::min(least, std::abs(dot(from, plane.normal)));
    }
    return least;
}

std::vector<uint8_t> worldImage(const Pose &camera, float gain = 1, Noise noise = {}) {
    std::vector<uint8_t> grey(120 * 100);
    renderWorld(room(), smallRays(), camera, grey.data(), 120, {gain, noise});
    return grey;
}

double mean(const std::vector<uint8_t> &grey) {
    return std::accumulate(grey.begin(), grey.end(), 0.0) / double(grey.size());
}

} // namespace

TEST(Scene, LandmarksLieOnSurfacesAndEveryTagHasFourCorners) {
    std::set<std::pair<int, int>> corners;
    for (const Landmark &landmark : room().landmarks()) {
        EXPECT_LT(distanceToSurfaces(landmark.position), 1e-6);
        corners.insert({landmark.tag, landmark.corner});
    }
    EXPECT_EQ(corners.size(), 200u);
    EXPECT_EQ(corners.rbegin()->first, 49);
}

TEST(Scene, ABoxHidesWhatIsBehindIt) {
    EXPECT_FALSE(room().isClear({0, 0, 0}, {1.6, -1.4, -2.8}));
    EXPECT_TRUE(room().isClear({0, 0, 0}, {0, 0, -3.5}));
}

TEST(Depth, EveryDistanceEndsOnASurface) {
    const PlumbBob lens = depthLens();
    for (const double seconds : {0.0, 3.3, 6.1}) {
        const Pose camera = depthPose(seconds);
        const DepthFrame frame(camera);
        for (uint32_t v = 0; v < 480; v += 7) {
            for (uint32_t u = 0; u < 544; u += 5) {
                const size_t i = size_t(v) * 544 + u;
                if (frame.flags[i] & (kDepthSaturated | kDepthLowSignal))
                    continue;
                const Vec3 ray = lens.unproject({double(u), double(v)});
                EXPECT_LT(distanceToSurfaces(transform(camera, double(frame.distance_m[i]) * ray)), 1e-5);
            }
        }
    }
}

TEST(Depth, OutOfRangeIsInvalidAndHasNoDistance) {
    const DepthFrame frame(depthPose(0), kShortRange);
    EXPECT_GT(frame.count(kDepthInvalid | kDepthLowSignal), 10000u);
    EXPECT_GT(frame.count(kDepthValid), 10000u);
    for (size_t i = 0; i < frame.flags.size(); i++) {
        EXPECT_LE(frame.distance_m[i], kShortRange.far_m);
        EXPECT_EQ(frame.distance_m[i] == 0, (frame.flags[i] & (kDepthLowSignal | kDepthSaturated)) != 0);
        EXPECT_EQ(frame.flags[i] != kDepthValid, (frame.flags[i] & kDepthInvalid) != 0);
    }
}

TEST(Depth, EdgesOfBoxesAreFlyingPixels) {
    const DepthFrame frame(depthPose(0));
    const size_t flying = frame.count(kDepthInvalid | kDepthFlyingPixel);
    EXPECT_GT(flying, 300u);
    EXPECT_LT(flying, 5000u);
}

TEST(Depth, TooNearIsSaturated) {
    const DepthFrame frame(facingFrontWall(0.3));
    EXPECT_GT(frame.count(kDepthInvalid | kDepthSaturated), 10000u);
}

TEST(Depth, ConfidenceFallsWithTheSquareOfDistance) {
    const DepthFrame near(facingFrontWall(1)), far(facingFrontWall(2));
    const double nearer =
        std::accumulate(near.confidence.begin() + 544 * 240, near.confidence.begin() + 544 * 241, 0.0);
    const double farther = std::accumulate(far.confidence.begin() + 544 * 240, far.confidence.begin() + 544 * 241, 0.0);
    EXPECT_GT(nearer / farther, 2.5);
    EXPECT_LT(nearer / farther, 6);
    for (size_t i = 0; i < near.raw.size(); i++)
        EXPECT_GE(near.raw[i], near.ambient[i]);
}

TEST(Depth, WhatIsTooFarHasLessConfidenceThanWhatIsMeasured) {
    const DepthFrame frame(depthPose(0), kShortRange);
    const auto meanOf = [&frame](uint32_t flags) {
        double sum = 0;
        for (size_t i = 0; i < frame.flags.size(); i++)
            sum += frame.flags[i] == flags ? frame.confidence[i] : 0;
        return sum / double(frame.count(flags));
    };
    EXPECT_LT(meanOf(kDepthInvalid | kDepthLowSignal), meanOf(kDepthValid));
}

TEST(Depth, TheInfraredImageMovesWithTheHead) {
    const DepthFrame first(depthPose(0)), later(depthPose(0.25));
    EXPECT_NE(first.raw, later.raw);
    EXPECT_NE(first.ambient, later.ambient);
}

TEST(Depth, NoiseHasItsDeviationAndComesBackWithItsFrame) {
    const DepthFrame exact(depthPose(0)), noisy(depthPose(0), kLongRange, {0.01f, 5, 3});
    const DepthFrame again(depthPose(0), kLongRange, {0.01f, 5, 3}), next(depthPose(0), kLongRange, {0.01f, 5, 4});
    double squares = 0;
    for (size_t i = 0; i < exact.distance_m.size(); i++) {
        squares += std::pow(noisy.distance_m[i] - exact.distance_m[i], 2);
    }
    EXPECT_NEAR(std::sqrt(squares / double(exact.count(kDepthValid))), 0.01, 0.0005);
    EXPECT_EQ(noisy.distance_m, again.distance_m);
    EXPECT_NE(noisy.distance_m, next.distance_m);
}

TEST(Depth, NoiseGrowsWithTheSquareOfTheDistance) {
    const DepthFrame exact(depthPose(0)), noisy(depthPose(0), kLongRange, {0.001f, 5, 3, 0.003f});
    double squares = 0;
    for (size_t i = 0; i < exact.distance_m.size(); i++) {
        const double expected = 0.001 + 0.003 * std::pow(exact.distance_m[i], 2);
        squares += std::pow((noisy.distance_m[i] - exact.distance_m[i]) / expected, 2);
    }
    EXPECT_NEAR(std::sqrt(squares / double(exact.count(kDepthValid))), 1, 0.05);
}

TEST(World, EqualArgumentsGiveEqualPixels) {
    const Pose camera = compose(Trajectory::looped(1, 10).at(2).head, mount(Camera::WorldLeft));
    EXPECT_EQ(worldImage(camera), worldImage(camera));
    EXPECT_NE(worldImage(camera), worldImage(camera, 1, {3, 1, 0}));
    EXPECT_EQ(worldImage(camera, 1, {3, 1, 9}), worldImage(camera, 1, {3, 1, 9}));
    EXPECT_NEAR(mean(worldImage(camera, 0.25f)), 0.25 * mean(worldImage(camera)), 3);
}

TEST(World, WhatLiesBetweenRowsIsLeftAlone) {
    std::vector<uint8_t> grey(128 * 100, 0xee);
    renderWorld(room(), smallRays(), {}, grey.data(), 128);
    for (int v = 0; v < 100; v++) {
        for (int u = 120; u < 128; u++)
            ASSERT_EQ(grey[v * 128 + u], 0xee);
    }
    EXPECT_EQ(std::vector<uint8_t>(grey.begin(), grey.begin() + 120), [] {
        auto all = worldImage({});
        return std::vector<uint8_t>(all.begin(), all.begin() + 120);
    }());
}

TEST(World, ACameraCanLookExactlyAlongAnAxis) {
    for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
        for (const double turn : {0.0, M_PI / 2, M_PI, -M_PI / 2}) {
            EXPECT_GT(mean(worldImage({Quaternion::about(axis, turn), {}})), 20);
        }
    }
}

TEST(Color, TheHologramIsSeenOnlyWhereItIs) {
    const RayTable rays(colorLens(640, 480));
    const auto image = [&rays](const Pose &camera, bool hologram) {
        std::vector<uint8_t> rgb(640 * 480 * 3);
        renderColor(room(), rays, camera, hologram, rgb.data(), 640 * 3);
        return rgb;
    };
    EXPECT_NE(image({}, true), image({}, false));
    EXPECT_NE(image({}, true), image({{}, {0.05, 0, 0}}, true)) << "it moves as the camera does";
    const Pose away = {Quaternion::about({0, 1, 0}, M_PI), {}};
    EXPECT_EQ(image(away, true), image(away, false));
}

TEST(Eye, ThePupilMovesAndTheFourCamerasDiffer) {
    const auto image = [](EyeCamera camera, double phase) {
        std::vector<uint8_t> grey(400 * 400);
        renderEye(camera, phase, grey.data(), 400);
        return grey;
    };
    const auto pupil = [](const std::vector<uint8_t> &grey) {
        double sum = 0, count = 0;
        for (size_t i = 0; i < grey.size(); i++) {
            if (grey[i] < 20) {
                sum += double(i % 400);
                count++;
            }
        }
        EXPECT_GT(count, 1000);
        return sum / count;
    };
    std::set<std::vector<uint8_t>> pictures;
    for (const EyeCamera camera :
         {EyeCamera::LeftTemple, EyeCamera::LeftNasal, EyeCamera::RightNasal, EyeCamera::RightTemple}) {
        EXPECT_GT(pupil(image(camera, 0)) - pupil(image(camera, 0.5)), 60);
        EXPECT_EQ(image(camera, 0), image(camera, 1));
        pictures.insert(image(camera, 0.2));
    }
    EXPECT_EQ(pictures.size(), 4u);
}
