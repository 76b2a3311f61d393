// Head, gaze and hands.
#include "../../sdk/ml_perception.h"
#include "../../sim/openxr/openxr_headers.h"
#include "trackers.h"

using ml2sim::jointInHead;
using ml2sim::Quaternion;
using ml2sim::Side;
using ml2sim::Vec3;

namespace {

class Poses : public EitherBackend {
  protected:
    void setHands(const char *visible, const char *hiddenKeyPoint, const char *hiddenJoint) const {
        if (isSdk()) {
            headset("hands_visible", visible);
            headset("hidden_key_point", hiddenKeyPoint);
        } else {
            runtime("hands.visible", visible);
            runtime("hands.hidden_joint", hiddenJoint);
        }
    }
    const ml2s_settings head = by(kHead), gaze = by(kGaze), hands = by(kHands);
};

/** Tests of OpenXR alone. */
using OpenXrPoses = OpenXr;
/** Tests of the vendor's interface alone. */
using SdkPoses = Trackers;

/** The time in ns for which the simulated head tracker is not tracked after it was created. */
constexpr int64_t kInitializing = 300'000'000;

} // namespace

INSTANTIATE_TEST_SUITE_P(By, Poses, kEither, nameOf);

TEST_P(Poses, TheHeadIsWhereItTrulyIsAtTheTimeOfThePose) {
    const int64_t opened = ml2s_now();
    Sensor sensor(head);
    const auto first = sensor.pollReading();
    if (ml2s_now() - opened < kInitializing) {
        EXPECT_EQ(first.is_tracked, isSdk() ? 0u : 1u) << "the vendor's tracking has just begun";
    }
    tracked(sensor);
    const int64_t before = ml2s_now();
    const auto pose = sensor.pollReading();
    expectNow(before, pose.capture_nanos, pose.device_nanos);
    expectAt(pose, {});
    EXPECT_EQ(pose.events, 0u);
}

TEST_P(Poses, TrackingIsLostAndRecoveredOnceEach) {
    Sensor sensor(head);
    EXPECT_EQ(tracked(sensor)[0].events, 0u);
    headset("fault.head.tracking", "2");
    const auto lost = sensor.pollReading();
    EXPECT_FALSE(lost.is_tracked);
    EXPECT_EQ(lost.events, ML2S_TRACKING_LOST);
    EXPECT_EQ(sensor.pollReading().events, 0u);
    headset("fault.head.tracking", "0");
    const auto recovered = sensor.pollReading();
    EXPECT_TRUE(recovered.is_tracked);
    EXPECT_EQ(recovered.events, ML2S_TRACKING_RECOVERED);
    EXPECT_EQ(sensor.pollReading().events, 0u);
}

TEST_F(SdkPoses, TheHeadSaysHowWellItIsTracked) {
    const int64_t opened = ml2s_now();
    Sensor sensor(onSdk(kHead));
    auto pose = sensor.pollReading();
    if (ml2s_now() - opened < kInitializing) {
        EXPECT_EQ(pose.values[ML2S_HEAD_STATUS], static_cast<float>(MLHeadTrackingStatus_Initializing));
        EXPECT_EQ(pose.values[ML2S_HEAD_CONFIDENCE], 0);
    }
    untilTracked(sensor, 1);
    headset("fault.head.confidence", "0.25");
    headset("fault.head.errors", "12");
    pose = sensor.pollReading();
    EXPECT_TRUE(pose.is_tracked);
    EXPECT_EQ(pose.values[ML2S_HEAD_STATUS], static_cast<float>(MLHeadTrackingStatus_Valid));
    EXPECT_EQ(pose.values[ML2S_HEAD_CONFIDENCE], 0.25f);
    EXPECT_EQ(pose.values[ML2S_HEAD_ERRORS],
              static_cast<float>(MLHeadTrackingErrorFlag_LowLight | MLHeadTrackingErrorFlag_ExcessiveMotion));
    headset("fault.head.tracking", "1");
    pose = sensor.pollReading();
    EXPECT_FALSE(pose.is_tracked);
    EXPECT_EQ(pose.values[ML2S_HEAD_STATUS], static_cast<float>(MLHeadTrackingStatus_Relocalizing));
    EXPECT_EQ(pose.values[ML2S_HEAD_ERRORS], 14);
}

TEST_F(OpenXrPoses, TheStatusOfTheHeadIsNotSaid) {
    EXPECT_EQ(Sensor(openXrSettings(ML2S_SENSOR_HEAD, bitOf(ML2S_STREAM_HEAD_POSE))).pollReading().values[0], -1);
}

TEST_F(OpenXrPoses, TheGazeSaysHowTheHeadsetFitsAndHowTheEyesAreCalibrated) {
    runtime("fault.calibration.silent", "1");
    Sensor sensor(openXrSettings(ML2S_SENSOR_GAZE, bitOf(ML2S_STREAM_GAZE)));
    const auto expect = [&](int fit, int calibration) {
        ml2s_reading gaze{};
        for (int i = 0; i < 3; i++) // the event comes with one poll at the latest
            gaze = sensor.pollReading();
        EXPECT_EQ(gaze.values[ML2S_GAZE_FIT], static_cast<float>(fit));
        EXPECT_EQ(gaze.values[ML2S_GAZE_CALIBRATION], static_cast<float>(calibration));
    };
    expect(-1, -1);
    runtime("fault.calibration.silent", "0");
    expect(XR_HEADSET_FIT_STATUS_GOOD_FIT_ML, XR_EYE_CALIBRATION_STATUS_FINE_ML);
    runtime("headset.fit", "3");
    expect(XR_HEADSET_FIT_STATUS_BAD_FIT_ML, XR_EYE_CALIBRATION_STATUS_FINE_ML);
    runtime("headset.fit", "2");
    runtime("eyes.calibration", "2");
    expect(XR_HEADSET_FIT_STATUS_GOOD_FIT_ML, XR_EYE_CALIBRATION_STATUS_COARSE_ML);
}

TEST_F(OpenXrPoses, ARuntimeThatRefusesToSayHowTheHeadsetFitsStillGivesTheGaze) {
    runtime("fault.calibration.refused", "1");
    Sensor sensor(openXrSettings(ML2S_SENSOR_GAZE, bitOf(ML2S_STREAM_GAZE)));
    const auto gaze = sensor.pollReading();
    EXPECT_TRUE(gaze.is_tracked);
    EXPECT_EQ(gaze.values[ML2S_GAZE_FIT], -1);
    EXPECT_EQ(gaze.values[ML2S_GAZE_CALIBRATION], -1);
}

TEST_P(Poses, ANewOriginOfTheWorldIsANewSession) {
    Sensor sensor(head);
    tracked(sensor);
    headset("fault.head.new_session", "1");
    const auto pose = sensor.pollReading();
    EXPECT_EQ(pose.events, ML2S_TRACKING_NEW_SESSION);
    expectAt(pose, {});
    EXPECT_EQ(sensor.pollReading().events, 0u);
}

TEST_P(Poses, GazeSwingsByTenDegreesBetweenTheEyes) {
    Sensor sensor(gaze);
    tracked(sensor);
    const int64_t before = ml2s_now();
    const auto pose = sensor.pollReading();
    const double phase = static_cast<double>(pose.device_nanos % 4000000000) / 4e9;
    EXPECT_EQ(pose.stream, uint32_t{ML2S_STREAM_GAZE});
    expectNow(before, pose.capture_nanos, pose.device_nanos);
    expectAt(pose, {Quaternion::about({0, 1, 0}, 10 * M_PI / 180 * std::sin(2 * M_PI * phase)), {0, 0, 0}});
}

TEST_P(Poses, TwoHandsHaveTheirJointsInOrder) {
    Sensor sensor(hands);
    const auto poses = tracked(sensor, 52);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        EXPECT_EQ(poses[i].stream, uint32_t{i < 26 ? ML2S_STREAM_HAND_LEFT : ML2S_STREAM_HAND_RIGHT});
        EXPECT_EQ(poses[i].id, i % 26);
        expectAt(poses[i], jointInHead(i < 26 ? Side::Left : Side::Right, i % 26));
    }
}

TEST_P(Poses, WhatExceedsTheCapacityIsLeftOut) {
    Sensor sensor(hands);
    EXPECT_EQ(poll(sensor, 30).size(), 30u);
}

TEST_P(Poses, AHandOrAJointThatIsNotSeenIsUntrackedInItsPlace) {
    constexpr uint32_t kIndexTip = 10; // of XrHandJointEXT
    setHands("2", "4", "10");
    Sensor sensor(hands);
    const auto poses = tracked(sensor, 52);
    ASSERT_EQ(poses.size(), 52u);
    for (uint32_t i = 0; i < 52; i++) {
        EXPECT_EQ(poses[i].is_tracked, i < 26 || i == 26 + kIndexTip ? 0u : 1u) << i;
    }
}

TEST_P(Poses, OneHandAloneCanBeAskedFor) {
    auto settings = hands;
    settings.streams = bitOf(ML2S_STREAM_HAND_RIGHT);
    Sensor sensor(settings);
    const auto poses = tracked(sensor, 52);
    ASSERT_EQ(poses.size(), 26u);
    EXPECT_EQ(poses[0].stream, uint32_t{ML2S_STREAM_HAND_RIGHT});
    expectAt(poses[10], jointInHead(Side::Right, 10));
}

TEST_P(Poses, AnUntrackedHeadsetTracksNeitherGazeNorHands) {
    Sensor eyes(gaze), both(hands);
    tracked(eyes);
    headset("fault.head.tracking", "1");
    EXPECT_FALSE(eyes.pollReading().is_tracked);
    for (const auto &pose : poll(both, 52)) {
        EXPECT_FALSE(pose.is_tracked);
    }
}

TEST_P(Poses, FramesAreNotToBeHadFromSensorsOfPoses) {
    Sensor sensor(head);
    EXPECT_TRUE(sensor.poll().empty());
    EXPECT_EQ(sensor.result, ML2S_INVALID_ARGUMENT);
}

TEST_F(OpenXrPoses, GazeOpensAgainInASessionThatGoesOn) {
    const Sensor head(kHead);
    for (int i = 0; i < 2; i++) {
        Sensor gaze(kGaze);
        EXPECT_TRUE(gaze.pollReading().is_tracked);
    }
    EXPECT_EQ(counters().sessions_created, 1u);
}

TEST_F(OpenXrPoses, ASystemWithoutGazeOrHandTrackingSaysSo) {
    runtime("fault.gaze.unsupported", "1");
    runtime("fault.hands.unsupported", "1");
    expectRefused(kGaze, ML2S_NOT_AVAILABLE, "not available: gaze (the system has no eye tracking)");
    expectRefused(kHands, ML2S_NOT_AVAILABLE, "not available: hands (the system has no hand tracking)");
}

TEST_F(SdkPoses, ClosedEyesLookNowhere) {
    Sensor sensor(onSdk(kGaze));
    untilTracked(sensor, 1);
    headset("fault.gaze.closed", "1");
    EXPECT_FALSE(sensor.pollReading().is_tracked);
    EXPECT_EQ(sensor.result, ML2S_OK);
    headset("fault.gaze.closed", "0");
    EXPECT_TRUE(sensor.pollReading().is_tracked);
}

TEST_F(SdkPoses, WhatCannotBeOpenedIsNamedAndLeavesNothing) {
    headset("fault.gaze.permission", "1");
    headset("fault.hands.permission", "1");
    headset("fault.controller.permission", "1");
    headset("fault.input.create", "1");
    EXPECT_EQ(Sensor(onSdk(kGaze)).result, ML2S_PERMISSION_DENIED);
    expectRefused(onSdk(kHands), ML2S_PERMISSION_DENIED, "MLHandTrackingCreateEx: PermissionDenied (7)");
    expectRefused(onSdk(kController), ML2S_PERMISSION_DENIED, "MLControllerCreateEx: PermissionDenied (7)");
    expectRefused(onSdk(kControllerInput), ML2S_VENDOR_FAILURE, "MLInputCreate: UnspecifiedFailure (4)");
}

TEST(SimulatedHands, HaveTheShapeOfHands) {
    const auto joint = [](Side side, uint32_t number) { return jointInHead(side, number).position; };
    EXPECT_NEAR(length(joint(Side::Right, 1) - Vec3{0.2, -0.3, -0.4}), 0, 1e-5);
    constexpr uint32_t kFirst[] = {2, 6, 11, 16, 21}, kTip[] = {5, 10, 15, 20, 25};
    for (uint32_t finger = 0; finger < 5; finger++) {
        for (uint32_t at = kFirst[finger]; at < kTip[finger]; at++) {
            const double bone = length(joint(Side::Right, at + 1) - joint(Side::Right, at));
            EXPECT_GT(bone, 0.014) << at;
            EXPECT_LT(bone, 0.075) << at;
        }
        // From the thumb to the little finger of a right hand with its palm down is from left to right.
        if (finger > 0) {
            EXPECT_GT(joint(Side::Right, kTip[finger]).x, joint(Side::Right, kTip[finger - 1]).x + 0.01);
        }
    }
    for (uint32_t at = 0; at < 26; at++) {
        const Vec3 left = joint(Side::Left, at);
        EXPECT_NEAR(length(Vec3{-left.x, left.y, left.z} - joint(Side::Right, at)), 0, 1e-5);
    }
}
