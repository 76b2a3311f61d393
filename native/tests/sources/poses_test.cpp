#include <algorithm>
#include <limits>

#include "scripted_sdk.h"
#include "sensor.h"

using scripted::script;

namespace {

class Head : public testing::Test {
  protected:
    Head() {
        script = {};
        script.transform = {{0.5f, -0.5f, 0.5f, 0.5f}, {1, 2, 3}};
    }
    const ml2s_settings settings = settingsOf(ML2S_SENSOR_HEAD, ML2S_STREAM_BIT(ML2S_STREAM_HEAD_POSE));
};

class ColorPose : public testing::Test {
  protected:
    ColorPose() {
        script = {};
        script.transform = {{0, 0, 0, 1}, {4, 5, 6}};
    }
    const ml2s_settings settings = settingsOf(ML2S_SENSOR_COLOR, ML2S_STREAM_BIT(ML2S_STREAM_COLOR));
};

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr MLTransform kUnusable[] = {
    {},
    {{kNaN, 0, 0, 1}, {1, 2, 3}},
    {{0, 0, 0, 1}, {1, kNaN, 3}},
    {{0, 0, 0, 0.5f}, {1, 2, 3}},
    {{0, 0, 0, 1e-40f}, {1, 2, 3}},
};

} // namespace

TEST_F(Head, ThePoseIsForExactlyTheTimeItIsStampedWith) {
    Sensor sensor(settings);
    const int64_t before = ml2s_now();
    const auto pose = sensor.pollReading();
    EXPECT_EQ(sensor.result, ML2S_OK);
    EXPECT_EQ(pose.device_nanos, script.snapshotTime);
    int64_t captured = 0;
    EXPECT_EQ(ml2s_boottime_of(script.snapshotTime, &captured, nullptr), ML2S_OK);
    EXPECT_EQ(pose.capture_nanos, captured);
    // Two clocks are compared, each right to half the time that reading both takes.
    EXPECT_GE(pose.capture_nanos, before - 1000000);
    EXPECT_LE(pose.capture_nanos, ml2s_now() + 1000000);
    EXPECT_EQ(pose.stream, ML2S_STREAM_HEAD_POSE);
    EXPECT_TRUE(pose.is_tracked);
    EXPECT_EQ(pose.rotation[1], -0.5f);
    EXPECT_EQ(pose.position[2], 3);
    EXPECT_EQ(script.calls.back(), "MLPerceptionReleaseSnapshot");
}

TEST_F(Head, OnlyStatusValidIsTracked) {
    Sensor sensor(settings);
    for (const uint32_t status : {0u, 1u, 2u, 99u}) {
        script.headStatus = status;
        const auto pose = sensor.pollReading();
        EXPECT_EQ(sensor.result, ML2S_OK);
        EXPECT_FALSE(pose.is_tracked);
    }
    EXPECT_EQ(script.countOf("MLPerceptionGetPredictedSnapshot"), 0);
}

TEST_F(Head, ASnapshotWithoutTheHeadIsAnUntrackedPoseAndIsReleased) {
    script.results["MLSnapshotGetTransform"] = MLResult_PoseNotFound;
    Sensor sensor(settings);
    EXPECT_FALSE(sensor.pollReading().is_tracked);
    EXPECT_EQ(sensor.result, ML2S_OK);
    EXPECT_EQ(script.calls.back(), "MLPerceptionReleaseSnapshot");
}

TEST_F(Head, ASnapshotThatFailsIsReleasedAndTold) {
    Sensor sensor(settings);
    for (const auto *function : {"MLPerceptionGetPredictedSnapshot", "MLSnapshotGetTransform"}) {
        script.results = {{function, MLResult_UnspecifiedFailure}};
        sensor.pollReading();
        EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
        EXPECT_EQ(std::string(sensor.error.message), std::string(function) + ": UnspecifiedFailure (4)");
    }
    EXPECT_EQ(script.calls.back(), "MLPerceptionReleaseSnapshot");
}

TEST_F(Head, AnInstantThatTheVendorDoesNotKnowGetsTheLatestSnapshotAndIsToldOnce) {
    Sensor sensor(settings);
    script.results["MLPerceptionGetPredictedSnapshot"] = MLResult_InvalidTimestamp;
    testing::internal::CaptureStderr();
    for (int i = 0; i < 2; i++) {
        EXPECT_TRUE(sensor.pollReading().is_tracked);
        EXPECT_EQ(sensor.result, ML2S_OK);
    }
    const auto told = testing::internal::GetCapturedStderr();
    const auto first = told.find("MLPerceptionGetPredictedSnapshot: InvalidTimestamp (15)");
    EXPECT_NE(first, std::string::npos) << told;
    EXPECT_EQ(told.find("MLPerception", first + 40), std::string::npos) << told;
    EXPECT_EQ(script.countOf("MLPerceptionReleaseSnapshot"), 1 + 2) << "one of the start, two of the poses";
}

TEST_F(Head, EventsOfAPollThatFailsComeWithTheNext) {
    Sensor sensor(settings);
    script.mapEvents = MLHeadTrackingMapEvent_NewSession;
    script.results["MLSnapshotGetTransform"] = MLResult_UnspecifiedFailure;
    sensor.pollReading();
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    script.results.clear();
    EXPECT_EQ(sensor.pollReading().events, uint32_t{ML2S_TRACKING_NEW_SESSION});
    EXPECT_EQ(sensor.pollReading().events, 0u);
}

TEST_F(Head, APoseThatIsNoneIsUntracked) {
    Sensor sensor(settings);
    for (const auto &transform : kUnusable) {
        script.transform = transform;
        EXPECT_FALSE(sensor.pollReading().is_tracked);
        EXPECT_EQ(sensor.result, ML2S_OK);
    }
}

TEST_F(Head, MapEventsArePassedOnOnce) {
    constexpr std::pair<uint64_t, uint32_t> kEvents[] = {
        {MLHeadTrackingMapEvent_Lost, ML2S_TRACKING_LOST},
        {MLHeadTrackingMapEvent_Recovered, ML2S_TRACKING_RECOVERED},
        {MLHeadTrackingMapEvent_RecoveryFailed, ML2S_TRACKING_RECOVERY_FAILED},
        {MLHeadTrackingMapEvent_Lost | MLHeadTrackingMapEvent_NewSession,
         ML2S_TRACKING_LOST | ML2S_TRACKING_NEW_SESSION},
    };
    Sensor sensor(settings);
    for (const auto &[vendors, own] : kEvents) {
        script.mapEvents = vendors;
        EXPECT_EQ(sensor.pollReading().events, own);
        EXPECT_EQ(sensor.pollReading().events, 0u);
    }
}

TEST_F(Head, ATrackerThatCannotBeUsedLeavesNothingOpen) {
    for (const auto &[function, destroyed] :
         {std::pair{"MLHeadTrackingCreate", 0}, std::pair{"MLHeadTrackingGetStaticData", 1}}) {
        script.results = {{function, MLResult_UnspecifiedFailure}};
        const Sensor sensor(settings);
        EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
        EXPECT_EQ(std::string(sensor.error.message), std::string(function) + ": UnspecifiedFailure (4)");
        EXPECT_EQ(script.countOf("MLHeadTrackingDestroy"), destroyed);
    }
}

TEST_F(ColorPose, ThePoseIsAskedForAtTheGivenTimeWithASnapshotTaken) {
    Sensor sensor(settings);
    const auto pose = sensor.colorPose(scripted::kOffsetNanos + 5);
    EXPECT_EQ(sensor.result, ML2S_OK);
    EXPECT_EQ(script.cameraPoseTime, scripted::kOffsetNanos + 5);
    EXPECT_EQ(pose.device_nanos, scripted::kOffsetNanos + 5);
    EXPECT_EQ(pose.stream, ML2S_STREAM_COLOR);
    EXPECT_EQ(pose.position[1], 5);
    EXPECT_TRUE(pose.is_tracked);
    const auto posed = std::find(script.calls.begin(), script.calls.end(), "MLCVCameraGetFramePose");
    ASSERT_GE(posed - script.calls.begin(), 2);
    EXPECT_EQ(posed[-2], "MLPerceptionGetSnapshot");
    EXPECT_EQ(posed[-1], "MLPerceptionReleaseSnapshot");
}

TEST_F(ColorPose, OutsideTheVendorsHistoryThereIsNoPose) {
    script.results["MLCVCameraGetFramePose"] = MLResult_PoseNotFound;
    Sensor sensor(settings);
    sensor.colorPose(scripted::kOffsetNanos);
    EXPECT_EQ(sensor.result, ML2S_NO_POSE);
    EXPECT_STREQ(sensor.error.message, "MLCVCameraGetFramePose: PoseNotFound (10)");
}

TEST_F(ColorPose, WhateverFailsCostsThePoseAndIsNamed) {
    Sensor sensor(settings);
    for (const auto *function : {"MLPerceptionGetSnapshot", "MLCVCameraGetFramePose"}) {
        script.results = {{function, MLResult_UnspecifiedFailure}};
        sensor.colorPose(scripted::kOffsetNanos);
        EXPECT_EQ(sensor.result, ML2S_NO_POSE);
        EXPECT_EQ(std::string(sensor.error.message), std::string(function) + ": UnspecifiedFailure (4)");
    }
    script.results.clear();
    for (const auto &transform : kUnusable) {
        script.transform = transform;
        EXPECT_FALSE(sensor.colorPose(scripted::kOffsetNanos).is_tracked);
        EXPECT_EQ(sensor.result, ML2S_OK);
    }
}

TEST_F(ColorPose, ADeniedCameraLeavesNothingOpen) {
    script.results["MLCVCameraTrackingCreate"] = MLResult_PermissionDenied;
    const Sensor sensor(settings);
    EXPECT_EQ(sensor.result, ML2S_PERMISSION_DENIED);
    EXPECT_EQ(script.countOf("MLHeadTrackingDestroy"), 1);
    EXPECT_EQ(script.countOf("MLCVCameraTrackingDestroy"), 0);
}
