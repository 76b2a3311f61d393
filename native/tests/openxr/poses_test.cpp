// Head, gaze and hands.
#include <cmath>

#include "openxr_fixture.h"
#include "scene/geometry.h"

using ml2sim::Pose;
using ml2sim::Quaternion;
using ml2sim::Vec3;

namespace {

class Poses : public OpenXr {
  protected:
    static Pose trueHead(int64_t device_nanos) {
        ml2sim_pose pose;
        ml2sim_true_head(device_nanos, &pose);
        const auto &q = pose.rotation;
        return {{q[0], q[1], q[2], q[3]}, {pose.position[0], pose.position[1], pose.position[2]}};
    }
    static void expectAt(const ml2s_pose &pose, const Pose &truth) {
        ASSERT_TRUE(pose.is_tracked);
        const auto &q = truth.rotation;
        const auto &r = pose.rotation;
        EXPECT_NEAR(std::fabs(q.x * r[0] + q.y * r[1] + q.z * r[2] + q.w * r[3]), 1, 1e-6);
        EXPECT_NEAR(pose.position[0], truth.position.x, 1e-5);
        EXPECT_NEAR(pose.position[1], truth.position.y, 1e-5);
        EXPECT_NEAR(pose.position[2], truth.position.z, 1e-5);
    }
    static Vec3 inHead(const ml2s_pose &pose) {
        const Vec3 place = {pose.position[0], pose.position[1], pose.position[2]};
        return transform(inverse(trueHead(pose.device_nanos)), place);
    }
    static std::vector<ml2s_pose> pollHands(const Sensor &hands) {
        std::vector<ml2s_pose> poses(52, sized<ml2s_pose>());
        uint32_t count = 0;
        EXPECT_EQ(ml2s_poll_poses(hands.handle(), poses.data(), 52, &count, nullptr), ML2S_OK);
        poses.resize(count);
        return poses;
    }
};

} // namespace

TEST_F(Poses, TheHeadIsWhereItTrulyIsAtTheTimeOfThePose) {
    Sensor head(kHead);
    const int64_t before = ml2s_now();
    const auto pose = head.pollPose();
    EXPECT_GE(pose.capture_nanos, before - kMillisecond);
    EXPECT_LE(pose.capture_nanos, ml2s_now() + kMillisecond);
    EXPECT_NEAR(static_cast<double>(pose.capture_nanos - ml2sim_boottime_of_mltime(pose.device_nanos)), 0, 50000);
    expectAt(pose, trueHead(pose.device_nanos));
    EXPECT_EQ(pose.events, 0u);
}

TEST_F(Poses, TrackingIsLostAndRecoveredOnceEach) {
    Sensor head(kHead);
    EXPECT_EQ(head.pollPose().events, 0u);
    headset("fault.head.tracking", "2");
    const auto lost = head.pollPose();
    EXPECT_FALSE(lost.is_tracked);
    EXPECT_EQ(lost.events, ML2S_TRACKING_LOST);
    EXPECT_EQ(head.pollPose().events, 0u);
    headset("fault.head.tracking", "0");
    EXPECT_EQ(head.pollPose().events, ML2S_TRACKING_RECOVERED);
    EXPECT_EQ(head.pollPose().events, 0u);
}

TEST_F(Poses, ANewOriginOfTheWorldIsANewSession) {
    Sensor head(kHead);
    head.pollPose();
    headset("fault.head.new_session", "1");
    const auto pose = head.pollPose();
    EXPECT_EQ(pose.events, ML2S_TRACKING_NEW_SESSION);
    expectAt(pose, trueHead(pose.device_nanos));
    EXPECT_EQ(head.pollPose().events, 0u);
}

TEST_F(Poses, GazeSwingsByTenDegreesInTheHead) {
    Sensor gaze(kGaze);
    const auto pose = gaze.pollPose();
    const double phase = static_cast<double>(pose.device_nanos % 4000000000) / 4e9;
    const auto inHead = Quaternion::about({0, 1, 0}, 10 * M_PI / 180 * std::sin(2 * M_PI * phase));
    expectAt(pose, compose(trueHead(pose.device_nanos), {inHead, {0, 0, 0}}));
}

TEST_F(Poses, GazeOpensAgainInASessionThatGoesOn) {
    const Sensor head(kHead);
    for (int i = 0; i < 2; i++) {
        Sensor gaze(kGaze);
        EXPECT_TRUE(gaze.pollPose().is_tracked);
    }
    EXPECT_EQ(counters().sessions_created, 1u);
}

TEST_F(Poses, ASystemWithoutGazeSaysSo) {
    runtime("fault.gaze.unsupported", "1");
    expectRefused(kGaze, ML2S_NOT_AVAILABLE, "not available: gaze (the system has no eye tracking)");
}

TEST_F(Poses, ASystemWithoutHandTrackingSaysSo) {
    runtime("fault.hands.unsupported", "1");
    expectRefused(kHands, ML2S_NOT_AVAILABLE, "not available: hands (the system has no hand tracking)");
}

TEST_F(Poses, TwoHandsHaveTheirJointsInOrder) {
    const Sensor hands(kHands);
    const auto poses = pollHands(hands);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        EXPECT_EQ(poses[i].stream, static_cast<uint32_t>(i < 26 ? ML2S_STREAM_HAND_LEFT : ML2S_STREAM_HAND_RIGHT));
        ASSERT_TRUE(poses[i].is_tracked);
    }
    EXPECT_NEAR(length(inHead(poses[27]) - Vec3{0.2, -0.3, -0.4}), 0, 1e-5);
}

TEST_F(Poses, HandsHaveTheShapeOfHands) {
    const Sensor hands(kHands);
    const auto poses = pollHands(hands);
    ASSERT_EQ(poses.size(), 52u);
    constexpr uint32_t kFirst[] = {2, 6, 11, 16, 21}, kTip[] = {5, 10, 15, 20, 25};
    for (uint32_t finger = 0; finger < 5; finger++) {
        for (uint32_t joint = kFirst[finger]; joint < kTip[finger]; joint++) {
            const double bone = length(inHead(poses[26 + joint + 1]) - inHead(poses[26 + joint]));
            EXPECT_GT(bone, 0.014) << joint;
            EXPECT_LT(bone, 0.075) << joint;
        }
        // From the thumb to the little finger of a right hand with its palm down is from left to right.
        if (finger > 0) {
            EXPECT_GT(inHead(poses[26 + kTip[finger]]).x, inHead(poses[26 + kTip[finger - 1]]).x + 0.01);
        }
    }
    for (uint32_t joint = 0; joint < 26; joint++) {
        const Vec3 left = inHead(poses[joint]), right = inHead(poses[26 + joint]);
        EXPECT_NEAR(length(Vec3{-left.x, left.y, left.z} - right), 0, 1e-5);
    }
}

TEST_F(Poses, AHandThatIsNotSeenHasAllItsJointsUntracked) {
    runtime("hands.visible", "2");
    const Sensor hands(kHands);
    const auto poses = pollHands(hands);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        EXPECT_EQ(poses[i].is_tracked, i < 26 ? 0u : 1u);
    }
}

TEST_F(Poses, AnUntrackedJointKeepsItsPlace) {
    runtime("hands.hidden_joint", "3");
    const Sensor hands(kHands);
    const auto poses = pollHands(hands);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        EXPECT_EQ(poses[i].is_tracked, i % 26 == 3 ? 0u : 1u);
    }
}

TEST_F(Poses, OneHandAloneCanBeAskedFor) {
    auto settings = kHands;
    settings.streams = bitOf(ML2S_STREAM_HAND_RIGHT);
    const Sensor hands(settings);
    const auto poses = pollHands(hands);
    ASSERT_EQ(poses.size(), 26u);
    EXPECT_EQ(poses[0].stream, static_cast<uint32_t>(ML2S_STREAM_HAND_RIGHT));
}

TEST_F(Poses, AnUntrackedHeadsetTracksNeitherGazeNorHands) {
    headset("fault.head.tracking", "1");
    Sensor gaze(kGaze);
    const Sensor hands(kHands);
    EXPECT_FALSE(gaze.pollPose().is_tracked);
    for (const auto &pose : pollHands(hands)) {
        EXPECT_FALSE(pose.is_tracked);
    }
}

TEST_F(Poses, FramesAreNotToBeHadFromSensorsOfPoses) {
    Sensor head(kHead);
    EXPECT_TRUE(head.poll().empty());
    EXPECT_EQ(head.result, ML2S_INVALID_ARGUMENT);
}
