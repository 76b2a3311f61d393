// Sensors of poses and input, through the vendor's C interface and through OpenXR.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../sim/eyes_and_hands.h"
#include "openxr_fixture.h"

/** A user who moves in real time. The end of each test checks that nothing of either interface is left. */
class Trackers : public OpenXr {
  protected:
    void SetUp() override {
        OpenXr::SetUp();
        headset("mltime_skew_ppm", "200");
    }
    void TearDown() override {
        OpenXr::TearDown();
        ml2sim_counters sdk;
        ml2sim_get_counters(&sdk);
        EXPECT_STREQ(sdk.last_misuse, "");
        EXPECT_EQ(sdk.open_handles + sdk.outstanding_snapshots, 0u);
    }
    static std::vector<ml2s_reading> poll(Sensor &sensor, uint32_t capacity) {
        std::vector<ml2s_reading> poses(capacity, sized<ml2s_reading>());
        uint32_t count = 0;
        sensor.result = ml2s_poll_readings(sensor.handle(), poses.data(), capacity, &count, &sensor.error);
        EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        poses.resize(count);
        return poses;
    }
    /** The poses once one is tracked, which takes the vendor's trackers a moment. */
    static std::vector<ml2s_reading> untilTracked(Sensor &sensor, uint32_t capacity) {
        const auto isTracked = [](const ml2s_reading &pose) { return pose.is_tracked != 0; };
        const int64_t end = ml2s_now() + 10000 * kMillisecond;
        auto poses = poll(sensor, capacity);
        while (sensor.result == ML2S_OK && std::none_of(poses.begin(), poses.end(), isTracked)) {
            if (ml2s_now() > end) {
                ADD_FAILURE() << "no pose is tracked within 10 s";
                break;
            }
            poses = poll(sensor, capacity);
        }
        return poses;
    }
    static void expectNow(int64_t before, int64_t capture_nanos, int64_t device_nanos) {
        EXPECT_GE(capture_nanos, before - kMillisecond);
        EXPECT_LE(capture_nanos, ml2s_now() + kMillisecond);
        EXPECT_NEAR(static_cast<double>(capture_nanos - ml2sim_boottime_of_mltime(device_nanos)), 0, 50000);
    }
    static void expectAt(const ml2s_reading &pose, const ml2sim::Pose &inHead) {
        ml2sim_pose head;
        ml2sim_true_head(pose.device_nanos, &head);
        const auto &q = head.rotation;
        const auto truth =
            compose({{q[0], q[1], q[2], q[3]}, {head.position[0], head.position[1], head.position[2]}}, inHead);
        const auto *r = pose.rotation;
        const auto &t = truth.rotation;
        ASSERT_TRUE(pose.is_tracked);
        EXPECT_NEAR(std::fabs(t.x * r[0] + t.y * r[1] + t.z * r[2] + t.w * r[3]), 1, 1e-6);
        EXPECT_NEAR(pose.position[0], truth.position.x, 1e-5);
        EXPECT_NEAR(pose.position[1], truth.position.y, 1e-5);
        EXPECT_NEAR(pose.position[2], truth.position.z, 1e-5);
    }
};

/** A test that runs through each interface. */
class EitherBackend : public Trackers, public testing::WithParamInterface<ml2s_backend> {
  protected:
    bool isSdk() const { return GetParam() == ML2S_BACKEND_SDK; }

    ml2s_settings by(ml2s_settings settings) const {
        settings.backend = GetParam();
        return settings;
    }
    std::vector<ml2s_reading> tracked(Sensor &sensor, uint32_t capacity = 1) const {
        return isSdk() ? untilTracked(sensor, capacity) : poll(sensor, capacity);
    }
};

inline const auto kEither = testing::Values(ML2S_BACKEND_SDK, ML2S_BACKEND_OPENXR);
inline std::string nameOf(const testing::TestParamInfo<ml2s_backend> &backend) {
    return backend.param == ML2S_BACKEND_SDK ? "sdk" : "openxr";
}
