#include "cameras.h"

#include <gtest/gtest.h>

using namespace ml2sim;

namespace {

template <class Lens> void expectRoundTrip(const Lens &lens) {
    for (double v = -2; v < lens.height + 2; v += lens.height / 31.0) {
        for (double u = -2; u < lens.width + 2; u += lens.width / 37.0) {
            const Vec3 ray = lens.unproject({u, v});
            EXPECT_NEAR(length(ray), 1, 1e-12);
            const auto pixel = lens.project(3.7 * ray);
            ASSERT_TRUE(pixel);
            EXPECT_NEAR(pixel->u, u, 1e-10 * lens.fx);
            EXPECT_NEAR(pixel->v, v, 1e-10 * lens.fy);
        }
    }
}

} // namespace

TEST(Lens, UnprojectInvertsProjectOverTheWholeImage) {
    for (const double tangential : {0.0, 1e-4, 1e-3})
        expectRoundTrip(worldLens(tangential, -tangential));
    expectRoundTrip(depthLens());
    expectRoundTrip(colorLens(1920, 1080));
    expectRoundTrip(colorLens(4096, 3072));
}

TEST(Lens, FisheyeBendsRadiallyFirstAndTangentiallyAfter) {
    const FisheyeTangential lens = worldLens(2e-3, -3e-3);
    // A point 1 right, 0.5 down, 1 ahead, worked out step by step.
    const double r = std::sqrt(1.25), theta = std::atan(r), q = theta * theta;
    const double bent = theta * (1 + 0.012 * q - 0.006 * q * q + 0.002 * q * q * q - 0.0004 * q * q * q * q);
    const double x = 1 / r * bent, y = 0.5 / r * bent, s = x * x + y * y;
    const auto pixel = lens.project({1, -0.5, -1});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->u, 582.0 * (x + 2 * 2e-3 * x * y - 3e-3 * (s + 2 * x * x)) + 506.3, 1e-9);
    EXPECT_NEAR(pixel->v, 581.4 * (y + 2e-3 * (s + 2 * y * y) - 2 * 3e-3 * x * y) + 509.8, 1e-9);
}

TEST(Lens, WhatIsBehindOrFarOffTheAxisIsNotSeen) {
    EXPECT_FALSE(worldLens().project({0, 0, 1}));
    EXPECT_FALSE(worldLens().project({1, 0, -0.01}));
    EXPECT_FALSE(depthLens().project({0.1, 0, 1}));
    EXPECT_FALSE(depthLens().project({1, 0, 0}));
}

TEST(Cameras, SeeAsWideAsTheirDataSheetSays) {
    EXPECT_NEAR(fovDegrees(worldLens()), 100, 2);
    EXPECT_NEAR(fovDegrees(depthLens()), 75, 2);
    EXPECT_NEAR(fovDegrees(colorLens(4096, 3072)), 75, 2);
    EXPECT_NEAR(fovDegrees(colorLens(1920, 1080)), 75, 2);
}

TEST(Cameras, ASmallerColorImageShowsTheSameScene) {
    const PlumbBob whole = colorLens(4096, 3072), half = colorLens(2048, 1536), cut = colorLens(2048, 1152);
    const Vec3 ray = {0.2, 0.1, -1};
    // Edges are at -0.5, so pixel 2n + 0.5 of the whole sensor is pixel n of half of it.
    EXPECT_NEAR(whole.project(ray)->u, 2 * half.project(ray)->u + 0.5, 1e-9);
    EXPECT_NEAR(whole.project(ray)->v, 2 * half.project(ray)->v + 0.5, 1e-9);
    EXPECT_NEAR(cut.project(ray)->v, half.project(ray)->v - (1536 - 1152) / 2.0, 1e-9);
    // Mixed reality is upright: its images are cut at both sides.
    const PlumbBob upright = colorLens(648, 720), wide = colorLens(960, 720);
    EXPECT_NEAR(upright.project(ray)->u, wide.project(ray)->u - (960 - 648) / 2.0, 1e-9);
    EXPECT_NEAR(upright.project(ray)->v, wide.project(ray)->v, 1e-9);
}

TEST(Cameras, TheLeftOneLooksLeftAndThePackIsTurned) {
    const Pose left = mount(Camera::WorldLeft);
    const Vec3 gaze = rotate(left.rotation, {0, 0, -1});
    EXPECT_LT(gaze.x, -0.6) << "40 degrees to the left";
    EXPECT_NEAR(gaze.y, -std::sin(10 * M_PI / 180), 1e-12) << "10 degrees down";
    EXPECT_EQ(left.position.x, -0.075);
    // Turned 90 degrees to the left, the right of the pack is ahead.
    const Vec3 right_of_pack = rotate(mount(Imu::ComputePack).rotation, {1, 0, 0});
    EXPECT_NEAR(right_of_pack.z, -1, 1e-12);
}
