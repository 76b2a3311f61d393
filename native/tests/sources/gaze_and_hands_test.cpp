// Gaze and hands against the simulated headset.
#include <cmath>

#include "eyes_and_hands.h"
#include "leak_check.h"

using ml2sim::Pose;
using ml2sim::Side;

namespace {

class Wearer : public LeakCheck {
  protected:
    /** Once tracking has begun. */
    static std::vector<ml2s_pose> poll(Sensor &sensor, uint32_t capacity) {
        std::vector<ml2s_pose> poses(capacity, sized<ml2s_pose>());
        uint32_t count = 0;
        const auto isAnyTracked = [&] {
            for (uint32_t i = 0; i < count; i++) {
                if (poses[i].is_tracked) {
                    return true;
                }
            }
            return false;
        };
        do {
            sensor.result = ml2s_poll_poses(sensor.handle(), poses.data(), capacity, &count, &sensor.error);
        } while (sensor.result == ML2S_OK && !isAnyTracked());
        EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        poses.resize(count);
        return poses;
    }

    static void expectAt(const ml2s_pose &pose, const Pose &inHead) {
        ml2sim_pose head;
        ml2sim_true_head(pose.device_nanos, &head);
        const auto &q = head.rotation;
        const auto truth =
            compose({{q[0], q[1], q[2], q[3]}, {head.position[0], head.position[1], head.position[2]}}, inHead);
        const auto *r = pose.rotation;
        const auto &t = truth.rotation;
        EXPECT_TRUE(pose.is_tracked);
        EXPECT_NEAR(std::fabs(t.x * r[0] + t.y * r[1] + t.z * r[2] + t.w * r[3]), 1, 1e-6);
        EXPECT_NEAR(pose.position[0], truth.position.x, 1e-5);
        EXPECT_NEAR(pose.position[1], truth.position.y, 1e-5);
        EXPECT_NEAR(pose.position[2], truth.position.z, 1e-5);
    }

    const ml2s_settings gaze = settingsOf(ML2S_SENSOR_GAZE, ML2S_STREAM_BIT(ML2S_STREAM_GAZE));
    const ml2s_settings hands =
        settingsOf(ML2S_SENSOR_HANDS, ML2S_STREAM_BIT(ML2S_STREAM_HAND_LEFT) | ML2S_STREAM_BIT(ML2S_STREAM_HAND_RIGHT));
};

} // namespace

TEST_F(Wearer, GazeGoesFromBetweenTheEyesToWhereBothLook) {
    Sensor sensor(gaze);
    const auto pose = poll(sensor, 1).front();
    EXPECT_EQ(pose.stream, uint32_t{ML2S_STREAM_GAZE});
    expectAt(pose, ml2sim::gazeInHead(pose.device_nanos));
    EXPECT_NEAR(static_cast<double>(pose.capture_nanos - ml2sim_boottime_of_mltime(pose.device_nanos)), 0, 50000);
}

TEST_F(Wearer, ClosedEyesLookNowhere) {
    Sensor sensor(gaze);
    poll(sensor, 1);
    set("fault.gaze.closed", "1");
    EXPECT_FALSE(sensor.pollPose().is_tracked);
    EXPECT_EQ(sensor.result, ML2S_OK);
    set("fault.gaze.closed", "0");
    EXPECT_TRUE(sensor.pollPose().is_tracked);
}

TEST_F(Wearer, TwoHandsHaveTheirJointsInOpenXrsOrder) {
    Sensor sensor(hands);
    const auto poses = poll(sensor, 52);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        const auto hand = i < 26 ? Side::Left : Side::Right;
        EXPECT_EQ(poses[i].stream, uint32_t{i < 26 ? ML2S_STREAM_HAND_LEFT : ML2S_STREAM_HAND_RIGHT});
        expectAt(poses[i], ml2sim::jointInHead(hand, i % 26));
    }
}

TEST_F(Wearer, AHandOrAJointThatIsNotSeenIsUntrackedInItsPlace) {
    constexpr uint32_t kIndexTip = 10; // of XrHandJointEXT
    set("hands_visible", "2");
    set("hidden_key_point", "4");
    Sensor sensor(hands);
    const auto poses = poll(sensor, 52);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        EXPECT_EQ(poses[i].is_tracked, i < 26 || i == 26 + kIndexTip ? 0u : 1u) << i;
    }
}

TEST_F(Wearer, OneHandAloneCanBeAskedFor) {
    auto settings = hands;
    settings.streams = ML2S_STREAM_BIT(ML2S_STREAM_HAND_RIGHT);
    Sensor sensor(settings);
    const auto poses = poll(sensor, 52);
    ASSERT_EQ(poses.size(), 26u);
    expectAt(poses[10], ml2sim::jointInHead(Side::Right, 10));
}

TEST_F(Wearer, AnUntrackedHeadsetTracksNeitherGazeNorHands) {
    Sensor eyes(gaze), both(hands);
    poll(eyes, 1);
    set("fault.head.tracking", "1");
    EXPECT_FALSE(eyes.pollPose().is_tracked);
    EXPECT_FALSE(both.pollPose().is_tracked);
    EXPECT_EQ(both.result, ML2S_OK);
}

TEST_F(Wearer, WithoutPermissionNothingIsLeftOpen) {
    set("fault.gaze.permission", "1");
    set("fault.hands.permission", "1");
    EXPECT_EQ(Sensor(gaze).result, ML2S_PERMISSION_DENIED);
    const Sensor sensor(hands);
    EXPECT_EQ(sensor.result, ML2S_PERMISSION_DENIED);
    EXPECT_STREQ(sensor.error.message, "MLHandTrackingCreateEx: PermissionDenied (7)");
}

TEST_F(Wearer, APausedTrackerIsGivenBackAndTakenAgain) {
    Sensor eyes(gaze), both(hands);
    for (auto *sensor : {&eyes, &both}) {
        EXPECT_EQ(sensor->pause(), ML2S_OK);
    }
    ml2sim_counters counters;
    ml2sim_get_counters(&counters);
    EXPECT_EQ(counters.open_handles, 0u);
    for (auto *sensor : {&eyes, &both}) {
        EXPECT_EQ(sensor->resume(), ML2S_OK);
    }
    poll(eyes, 1);
    poll(both, 52);
}
