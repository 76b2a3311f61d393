#include <cmath>
#include <cstring>

#include "scripted_sdk.h"
#include "sensor.h"

using scripted::script;

namespace {

constexpr uint32_t kWidth = 8;
constexpr uint32_t kHeight = 6;
constexpr uint32_t kStride = kWidth * 4 + 12;
constexpr uint64_t kDepth = ML2S_STREAM_BIT(ML2S_STREAM_DEPTH);
constexpr uint64_t kInfra = ML2S_STREAM_BIT(ML2S_STREAM_INFRA);

/** A padded plane of the vendor's, each pixel of its own value. */
template <class T> struct Plane {
    std::vector<T> pixels = std::vector<T>(kStride / 4 * kHeight);
    MLDepthCameraFrameBuffer buffer = {kWidth, kHeight, kStride, 4, kStride *kHeight, pixels.data()};

    explicit Plane(T base) {
        for (uint32_t i = 0; i < pixels.size(); i++) {
            pixels[i] = base + static_cast<T>(i);
        }
    }
    Plane(const Plane &) = delete;
    T &at(uint32_t x, uint32_t y) { return pixels[y * kStride / 4 + x]; }
};

template <class T> T pixel(const ml2s_frame &frame, ml2s_plane_role role, uint32_t x, uint32_t y) {
    T value;
    const auto &plane = frame.planes[role];
    std::memcpy(&value, frame.data + plane.offset_bytes + y * plane.stride_bytes + x * sizeof value, sizeof value);
    return value;
}

class Depth : public testing::Test {
  protected:
    Depth() {
        script = {};
        flags.pixels.assign(flags.pixels.size(), 0);
        frame.frame_number = 41;
        frame.frame_timestamp = scripted::kOffsetNanos + 5000000001;
        frame.frame_type = MLDepthCameraFrameType_LongRange;
        frame.camera_pose = {{0.5f, -0.5f, 0.5f, 0.5f}, {1, 2, 3}};
        frame.intrinsics = {kWidth, kHeight, {6, 5}, {3.5f, 2.5f}, 75, {0, 0, 0, 0, 0}};
        frame.depth_image = &distances.buffer;
        frame.confidence = &confidence.buffer;
        frame.flags = &flags.buffer;
        frame.raw_depth_image = &raw.buffer;
        script.depthFrames = {frame};
    }

    void expectOddOf(const std::string &text, uint32_t wants = ML2S_WANT_CONFIDENCE) {
        auto settings = depth;
        settings.wants = wants;
        const auto before = script.countOf("MLDepthCameraReleaseDepthData");
        Sensor sensor(settings);
        expectOdd(sensor, text);
        EXPECT_EQ(script.countOf("MLDepthCameraReleaseDepthData") - before, int{ML2S_MOST_UNUSABLE_CAPTURES});
    }

    const ml2s_settings depth = settingsOf(ML2S_SENSOR_DEPTH, kDepth);
    Plane<float> distances{1}, confidence{1000}, raw{2000};
    Plane<uint32_t> flags{0};
    MLDepthCameraFrame frame = {};
    Slots slots{ML2S_STREAM_DEPTH, 2};
};

} // namespace

TEST_F(Depth, AFrameIsReleasedBeforeThePollReturns) {
    Sensor sensor(depth);
    const Only got(sensor.poll());
    EXPECT_EQ(script.countOf("MLDepthCameraGetLatestDepthData"), 1);
    EXPECT_EQ(script.calls.back(), "MLDepthCameraReleaseDepthData");
}

TEST_F(Depth, RadialDepthConfidenceAndFlagsAreCopiedWithoutPadding) {
    flags.at(2, 1) = MLDepthCameraDepthFlags_StrayLight;
    auto settings = depth;
    settings.wants = ML2S_WANT_RADIAL | ML2S_WANT_CONFIDENCE | ML2S_WANT_FLAGS;
    Sensor sensor(settings);
    const Only got(sensor.poll());
    uint32_t offset = 0;
    for (const auto role : {ML2S_PLANE_IMAGE, ML2S_PLANE_CONFIDENCE, ML2S_PLANE_FLAGS}) {
        EXPECT_EQ(got.planes[role].offset_bytes, offset);
        EXPECT_EQ(got.planes[role].stride_bytes, kWidth * 4);
        EXPECT_EQ(got.planes[role].size_bytes, kWidth * kHeight * 4);
        offset += 192; // 8 * 6 * 4, which is a multiple of 64.
    }
    for (uint32_t y = 0; y < kHeight; y++) {
        for (uint32_t x = 0; x < kWidth; x++) {
            EXPECT_EQ(pixel<float>(got, ML2S_PLANE_IMAGE, x, y), distances.at(x, y));
            EXPECT_EQ(pixel<float>(got, ML2S_PLANE_CONFIDENCE, x, y), confidence.at(x, y));
            EXPECT_EQ(pixel<uint32_t>(got, ML2S_PLANE_FLAGS, x, y), flags.at(x, y));
        }
    }
}

TEST_F(Depth, ZIsTheDistanceTimesTheCosineOfTheRaysAngle) {
    Sensor sensor(depth);
    const Only got(sensor.poll());
    for (uint32_t y = 0; y < kHeight; y++) {
        for (uint32_t x = 0; x < kWidth; x++) {
            const double ray = std::hypot((x - 3.5) / 6, (y - 2.5) / 5, 1.0);
            EXPECT_NEAR(pixel<float>(got, ML2S_PLANE_IMAGE, x, y), distances.at(x, y) / ray, 1e-5);
        }
    }
}

TEST_F(Depth, ZFollowsTheLensDistortion) {
    // A point seen through the lens: its pixel is where the forward model puts it.
    const double k1 = -0.1, k2 = 0.02, p1 = 0.003, p2 = -0.002, k3 = 0.001, x = 0.31, y = -0.27, r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    auto &intrinsics = script.depthFrames[0].intrinsics;
    intrinsics.focal_length = {100, 100};
    intrinsics.principal_point = {static_cast<float>(3 - 100 * xd), static_cast<float>(4 - 100 * yd)};
    const double distortion[] = {k1, k2, p1, p2, k3};
    std::memcpy(intrinsics.distortion, distortion, sizeof distortion);
    Sensor sensor(depth);
    const Only got(sensor.poll());
    const double z = distances.at(3, 4) / std::hypot(x, y, 1.0);
    EXPECT_NEAR(pixel<float>(got, ML2S_PLANE_IMAGE, 3, 4), z, 1e-5 * z);
}

TEST_F(Depth, NewIntrinsicsAreUsedFromTheirFirstFrame) {
    Sensor sensor(depth);
    sensor.poll();
    script.depthFrames[0].intrinsics.focal_length = {12, 10};
    const Only got(sensor.poll());
    const double ray = std::hypot(3.5 / 12, 2.5 / 10, 1.0);
    EXPECT_NEAR(pixel<float>(got, ML2S_PLANE_IMAGE, 0, 0), distances.at(0, 0) / ray, 1e-5);
}

TEST_F(Depth, WhatIsNoDepthIsNotANumber) {
    flags.at(0, 0) = MLDepthCameraDepthFlags_Invalid | MLDepthCameraDepthFlags_SBI;
    distances.at(1, 0) = 0;
    distances.at(2, 0) = -1;
    distances.at(3, 0) = INFINITY;
    distances.at(4, 0) = NAN;
    flags.at(5, 0) = MLDepthCameraDepthFlags_Saturated; // Without Invalid the vendor stands by it.
    Sensor sensor(depth);
    const Only got(sensor.poll());
    for (uint32_t x = 0; x < 5; x++) {
        EXPECT_TRUE(std::isnan(pixel<float>(got, ML2S_PLANE_IMAGE, x, 0))) << x;
    }
    EXPECT_FALSE(std::isnan(pixel<float>(got, ML2S_PLANE_IMAGE, 5, 0)));
    EXPECT_EQ(got.planes[ML2S_PLANE_FLAGS].size_bytes, 0u) << "flags are asked of the vendor, not wanted here";
}

TEST_F(Depth, MetadataIsPassedAsTheVendorGaveIt) {
    Sensor sensor(depth);
    const Only got(sensor.poll());
    EXPECT_EQ(got.stream, ML2S_STREAM_DEPTH);
    EXPECT_EQ(got.frame_number, 41);
    EXPECT_EQ(got.device_nanos, scripted::kOffsetNanos + 5000000001);
    timespec boottime, monotonic;
    clock_gettime(CLOCK_BOOTTIME, &boottime);
    clock_gettime(CLOCK_MONOTONIC, &monotonic);
    const int64_t slept = (boottime.tv_sec - monotonic.tv_sec) * 1000000000 + boottime.tv_nsec - monotonic.tv_nsec;
    EXPECT_NEAR(static_cast<double>(got.capture_nanos), 5000000001.0 + static_cast<double>(slept), 1e6);
    EXPECT_EQ(std::memcmp(got.rotation, &frame.camera_pose, sizeof frame.camera_pose), 0);
    EXPECT_EQ(got.has, uint32_t{ML2S_HAS_POSE | ML2S_HAS_INTRINSICS});
    EXPECT_EQ(got.lens, ML2S_LENS_PLUMB_BOB);
    EXPECT_EQ(got.focal_length[1], 5);
    EXPECT_EQ(got.principal_point[0], 3.5);
}

TEST_F(Depth, InfraIsTheRawPictureWithTheLightOn) {
    const Slots infraSlots(ML2S_STREAM_INFRA);
    Sensor sensor(settingsOf(ML2S_SENSOR_DEPTH, kInfra));
    EXPECT_EQ(script.depthSettings.stream_configs[0].flags, MLDepthCameraFlags_RawDepthImage);
    script.depthFrames[0].depth_image = script.depthFrames[0].flags = nullptr;
    const Only got(sensor.poll());
    EXPECT_EQ(got.stream, ML2S_STREAM_INFRA);
    EXPECT_EQ(pixel<float>(got, ML2S_PLANE_IMAGE, 7, 5), raw.at(7, 5));
    EXPECT_TRUE(got.has & ML2S_HAS_ILLUMINATION && got.illumination);
}

TEST_F(Depth, EveryRateAndRangeReachesTheVendorAsItsOwnValue) {
    const std::pair<uint32_t, MLDepthCameraFrameRate> rates[] = {{1, 0}, {5, 1}, {25, 2}, {30, 3}, {50, 4}, {60, 5}};
    for (const auto &[rate_hz, rate] : rates) {
        auto settings = settingsOf(ML2S_SENSOR_DEPTH, kDepth, rate_hz > 5 ? kDepth : 0);
        settings.rate_hz = rate_hz;
        settings.wants = rate_hz == 60 ? ML2S_WANT_CONFIDENCE : 0;
        Sensor sensor(settings);
        ASSERT_EQ(sensor.result, ML2S_OK);
        const auto &config = script.depthSettings.stream_configs[rate_hz > 5];
        EXPECT_EQ(script.depthSettings.streams, rate_hz > 5 ? 2u : 1u);
        EXPECT_EQ(config.frame_rate, rate);
        EXPECT_EQ(config.exposure, rate_hz > 5 ? 375u : 1600u);
        EXPECT_EQ(config.flags, rate_hz == 60 ? 7u : 5u);
    }
}

TEST_F(Depth, ARateThatTheCameraHasNotIsRefusedBeforeTheVendorIsAsked) {
    auto settings = depth;
    settings.rate_hz = 15;
    const Sensor sensor(settings);
    EXPECT_EQ(sensor.result, ML2S_INVALID_ARGUMENT);
    EXPECT_STREQ(sensor.error.message, "depth: 15 Hz, expected 1, 5, 25, 30, 50 or 60");
    EXPECT_TRUE(script.calls.empty());
    const Sensor both(settingsOf(ML2S_SENSOR_DEPTH, kDepth | kInfra));
    EXPECT_EQ(both.result, ML2S_INVALID_ARGUMENT);
}

TEST_F(Depth, OtherSettingsThatTheVendorRefusesLeaveTheOldOnesInForce) {
    Sensor sensor(depth);
    script.results["MLDepthCameraUpdateSettings"] = MLResult_InvalidParam;
    EXPECT_EQ(sensor.configure(settingsOf(ML2S_SENSOR_DEPTH, kInfra)), ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message, "MLDepthCameraUpdateSettings: InvalidParam (5)");
    const Only got(sensor.poll());
    EXPECT_EQ(got.stream, ML2S_STREAM_DEPTH);
}

TEST_F(Depth, AFrameOfTheRangeOfBeforeIsLeft) {
    Sensor sensor(depth);
    EXPECT_EQ(sensor.configure(settingsOf(ML2S_SENSOR_DEPTH, kDepth, kDepth)), ML2S_OK);
    EXPECT_TRUE(sensor.poll().empty());
    EXPECT_EQ(sensor.result, ML2S_TIMEOUT);
    EXPECT_EQ(script.countOf("MLDepthCameraReleaseDepthData"), 1);
}

TEST_F(Depth, WithoutAFreeSlotTheFrameIsLostAndReleased) {
    Sensor sensor(depth);
    const auto first = sensor.poll(), second = sensor.poll(), third = sensor.poll();
    ASSERT_EQ(third.size(), 1u);
    EXPECT_EQ(third[0].slot, ML2S_NO_SLOT);
    EXPECT_EQ(third[0].data, nullptr);
    EXPECT_EQ(third[0].planes[0].size_bytes, 0u);
    EXPECT_EQ(third[0].frame_number, 41);
    EXPECT_EQ(script.countOf("MLDepthCameraReleaseDepthData"), 3);
}

TEST_F(Depth, ATimeoutIsNoErrorAndNothingIsReleased) {
    script.results["MLDepthCameraGetLatestDepthData"] = MLResult_Timeout;
    Sensor sensor(depth);
    EXPECT_TRUE(sensor.poll(1000001).empty());
    EXPECT_EQ(sensor.result, ML2S_TIMEOUT);
    EXPECT_EQ(script.timeout_ms, 2u) << "rounded up";
    EXPECT_EQ(script.countOf("MLDepthCameraReleaseDepthData"), 0);
}

TEST_F(Depth, AFailedReleaseIsToldAndTheSlotComesBack) {
    script.results["MLDepthCameraReleaseDepthData"] = MLResult_UnspecifiedFailure;
    Sensor sensor(depth);
    EXPECT_TRUE(sensor.poll().empty());
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message, "MLDepthCameraReleaseDepthData: UnspecifiedFailure (4)");
}

TEST_F(Depth, MissingBuffersAreRefused) {
    script.depthFrames[0].confidence = nullptr;
    expectOddOf("depth confidence: empty picture of 0x0");
}

TEST_F(Depth, ABufferSmallerThanItsRowsIsRefused) {
    flags.buffer.size = kStride * (kHeight - 1) + kWidth * 4 - 1;
    expectOddOf("depth flags: 8x6 pixels with stride 44 do not fit 251 bytes");
}

TEST_F(Depth, AlignmentOfPixelsIsChecked) {
    distances.buffer.data = reinterpret_cast<uint8_t *>(distances.pixels.data()) + 1;
    expectOddOf("not aligned");
}

TEST_F(Depth, PlanesOfUnequalSizeAreRefused) {
    flags.buffer.height = kHeight - 1;
    expectOddOf("depth flags: 8x5 pixels, intrinsics for 8x6");
}

TEST_F(Depth, PicturesLargerThanTheCameraHasAreRefused) {
    std::vector<float> large(545 * 4);
    distances.buffer = {545, 4, 545 * 4, 4, 545 * 4 * 4, large.data()};
    script.depthFrames[0].intrinsics.width = 545;
    script.depthFrames[0].intrinsics.height = 4;
    expectOddOf("at most 544x480");
}

TEST_F(Depth, DistanceCannotBecomeZWithoutIntrinsics) {
    script.depthFrames[0].intrinsics.focal_length.x = NAN;
    expectOddOf("intrinsics are not finite");
    for (float focal : {0.0f, -6.0f, 1e9f, INFINITY}) {
        script.depthFrames[0].intrinsics.focal_length.x = focal;
        expectOddOf("intrinsics are not finite");
    }
    script.depthFrames[0].intrinsics.focal_length.x = 6;
    script.depthFrames[0].intrinsics.distortion[4] = NAN;
    expectOddOf("intrinsics are not finite");
}

TEST_F(Depth, APoseThatIsNoNumberIsNone) {
    script.depthFrames[0].camera_pose.position.x = INFINITY;
    Sensor sensor(depth);
    EXPECT_EQ(Only(sensor.poll()).has, uint32_t{ML2S_HAS_INTRINSICS});
}
