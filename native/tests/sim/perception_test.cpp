// Startup, snapshots, head tracking, the colour camera's pose.
#include <cmath>
#include <cstring>
#include <thread>

#include "ml_unused.h"
#include "perception_fixture.h"

class Perception : public TrackedHeadset {
  protected:
    MLHeadTrackingStateEx state() {
        auto out = initialised(MLHeadTrackingStateExInit);
        EXPECT_EQ(MLHeadTrackingGetStateEx(tracker, &out), MLResult_Ok);
        return out;
    }
    uint64_t events() {
        uint64_t out = ~0ull;
        EXPECT_EQ(MLHeadTrackingGetMapEvents(tracker, &out), MLResult_Ok);
        return out;
    }
    MLCoordinateFrameUID headFrame() {
        MLHeadTrackingStaticData frames;
        MLHeadTrackingGetStaticData(tracker, &frames);
        return frames.coord_frame_head;
    }
    MLResult headAt(MLTime time, MLTransform *out) {
        MLSnapshot *snapshot = nullptr;
        const auto result = MLPerceptionGetPredictedSnapshot(time, &snapshot);
        if (result != MLResult_Ok)
            return result;
        const auto frame = headFrame();
        const auto found = MLSnapshotGetTransform(snapshot, &frame, out);
        MLPerceptionReleaseSnapshot(snapshot);
        return found;
    }
    static void expectEqual(const MLTransform &transform, const ml2sim_pose &truth) {
        const float *q = &transform.rotation.x, *p = &transform.position.x;
        for (int i = 0; i < 4; i++)
            EXPECT_NEAR(q[i], truth.rotation[i], 1e-6);
        for (int i = 0; i < 3; i++)
            EXPECT_NEAR(p[i], truth.position[i], 1e-6);
    }
};

using BeforeStartup = SimulatedHeadset;

TEST_F(BeforeStartup, EverythingThatKnowsPosesIsNotStarted) {
    MLHandle handle = 0;
    MLSnapshot *snapshot = nullptr;
    MLTransform transform;
    EXPECT_EQ(MLHeadTrackingCreate(&handle), MLResult_PerceptionSystemNotStarted);
    EXPECT_EQ(MLPerceptionGetSnapshot(&snapshot), MLResult_PerceptionSystemNotStarted);
    EXPECT_EQ(MLCVCameraTrackingCreate(&handle), MLResult_PerceptionSystemNotStarted);
    EXPECT_EQ(MLCVCameraGetFramePose(1, 1, 0, 0, &transform), 12);
}

TEST_F(BeforeStartup, AFailingStartupFailsAndAShutdownWithoutOneIsToldSo) {
    MLPerceptionSettings settings{};
    set("fault.perception.startup", "1");
    EXPECT_EQ(MLPerceptionStartup(&settings), MLResult_UnspecifiedFailure);
    EXPECT_EQ(MLPerceptionShutdown(), MLResult_PerceptionSystemNotStarted);
    expectMisuse(ML2SIM_MISUSE_RELEASE);
}

TEST_F(Perception, AStartAndAShutdownAreOfTheWholeProcess) {
    start();
    expectMisuse(ML2SIM_MISUSE_CLIENTS);
    EXPECT_EQ(MLPerceptionShutdown(), MLResult_Ok);
    expectMisuse(ML2SIM_MISUSE_UNRELEASED);
    EXPECT_EQ(counters().is_perception_started, 0u);
    start();
}

TEST_F(BeforeStartup, TheSystemOfTheAppIsNotToBeStartedOrShutDown) {
    set("app_perception", "1");
    MLPerceptionSettings settings{};
    EXPECT_EQ(MLPerceptionShutdown(), MLResult_Ok);
    expectMisuse(ML2SIM_MISUSE_RELEASE);
    MLHandle tracker = 0;
    ASSERT_EQ(MLHeadTrackingCreate(&tracker), MLResult_Ok);
    MLHeadTrackingDestroy(tracker);
    EXPECT_EQ(MLPerceptionStartup(&settings), MLResult_Ok);
    expectMisuse(ML2SIM_MISUSE_CLIENTS);
    MLPerceptionShutdown();
}

TEST_F(BeforeStartup, ATrackerNeedsAFirstSnapshotWhichTakesAMoment) {
    set("perception_startup_s", "1");
    MLPerceptionSettings settings{};
    MLHandle tracker = 0;
    MLSnapshot *snapshot = nullptr;
    ASSERT_EQ(MLPerceptionStartup(&settings), MLResult_Ok);
    EXPECT_EQ(MLPerceptionGetSnapshot(&snapshot), MLResult_PerceptionSystemNotStarted);
    ml2sim_advance(kSecond);
    EXPECT_EQ(MLHeadTrackingCreate(&tracker), MLResult_UnspecifiedFailure);
    ASSERT_EQ(MLPerceptionGetSnapshot(&snapshot), MLResult_Ok);
    MLPerceptionReleaseSnapshot(snapshot);
    ASSERT_EQ(MLHeadTrackingCreate(&tracker), MLResult_Ok);
    MLHeadTrackingDestroy(tracker);
    MLPerceptionShutdown();
}

TEST_F(Perception, OnlyOneThreadHasSnapshots) {
    const Snapshot held;
    std::thread([] { const Snapshot other; }).join();
    expectMisuse(ML2SIM_MISUSE_THREAD);
}

TEST_F(Perception, ShutdownWithOpenThingsIsTold) {
    const Snapshot open;
    EXPECT_EQ(MLPerceptionShutdown(), MLResult_Ok);
    expectMisuse(ML2SIM_MISUSE_UNRELEASED);
    start();
}

TEST_F(Perception, AHeadTrackerInitialisesForAMomentAndHasNoPoseTillThen) {
    MLHeadTrackingDestroy(tracker);
    ASSERT_EQ(MLHeadTrackingCreate(&tracker), MLResult_Ok);
    MLTransform head;
    EXPECT_EQ(state().status, uint32_t{MLHeadTrackingStatus_Initializing});
    EXPECT_EQ(headAt(ml2sim_now_mltime(), &head), MLResult_PoseNotFound);
    ml2sim_advance(kSecond);
    EXPECT_EQ(state().status, uint32_t{MLHeadTrackingStatus_Valid});
    EXPECT_EQ(headAt(ml2sim_now_mltime(), &head), MLResult_Ok);
}

TEST_F(Perception, ASnapshotIsTheHeadAtItsTime) {
    for (const int64_t ahead : {-400, 0, 100}) {
        const auto time = ml2sim_now_mltime() + ahead * kMillisecond;
        MLTransform head;
        ASSERT_EQ(headAt(time, &head), MLResult_Ok);
        ml2sim_pose truth;
        ml2sim_true_head(time, &truth);
        expectEqual(head, truth);
    }
}

TEST_F(Perception, TimesTooFarAheadOrTooOldAreInvalid) {
    MLTransform head;
    EXPECT_EQ(headAt(ml2sim_now_mltime() + 100 * kMillisecond + 1, &head), MLResult_InvalidTimestamp);
    EXPECT_EQ(headAt(ml2sim_now_mltime() - 501 * kMillisecond, &head), MLResult_InvalidTimestamp);
}

TEST_F(Perception, ASnapshotIsReleasedOnceAndUnusableAfter) {
    MLSnapshot *snapshot = nullptr;
    ASSERT_EQ(MLPerceptionGetSnapshot(&snapshot), MLResult_Ok);
    EXPECT_EQ(counters().outstanding_snapshots, 1u);
    EXPECT_EQ(MLPerceptionReleaseSnapshot(snapshot), MLResult_Ok);
    EXPECT_EQ(MLPerceptionReleaseSnapshot(snapshot), MLResult_InvalidParam);
    MLCoordinateFrameUID id{};
    MLTransform transform;
    EXPECT_EQ(MLSnapshotGetTransform(snapshot, &id, &transform), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_RELEASE, 2);
}

TEST_F(Perception, AnUnknownFrameHasNoPoseAndTheOriginIsTheOrigin) {
    const Snapshot snapshot;
    MLTransform transform;
    EXPECT_EQ(snapshot.find({{1, 2}}, &transform), MLResult_PoseNotFound);
    MLSnapshotStaticData frames = {1, {}};
    ASSERT_EQ(MLSnapshotGetStaticData(&frames), MLResult_Ok);
    ASSERT_EQ(snapshot.find(frames.coord_world_origin, &transform), MLResult_Ok);
    EXPECT_EQ(transform.rotation.w, 1);
    EXPECT_EQ(transform.position.x, 0);
}

TEST_F(Perception, DerivativesAreThoseOfThePath) {
    const auto now = ml2sim_now_mltime();
    const Snapshot snapshot(now);
    const auto frame = headFrame();
    MLTransform transform;
    MLTransformDerivatives derivatives{};
    derivatives.version = 1;
    ASSERT_EQ(MLSnapshotGetTransformWithDerivatives(snapshot.get(), &frame, &transform, &derivatives), MLResult_Ok);
    ml2sim_pose before, after;
    ml2sim_true_head(now - 500000, &before);
    ml2sim_true_head(now + 500000, &after);
    EXPECT_NEAR(derivatives.linear_velocity_m_s.x, (after.position[0] - before.position[0]) * 1000, 1e-3);
    EXPECT_NEAR(derivatives.linear_velocity_m_s.z, (after.position[2] - before.position[2]) * 1000, 1e-3);
}

TEST_F(Perception, APoseInTheHeadUndoesThePoseOfTheHead) {
    const auto now = ml2sim_now_mltime();
    const Snapshot snapshot(now);
    const auto frame = headFrame();
    MLPose pose;
    ASSERT_EQ(MLSnapshotGetPoseInBase(snapshot.get(), &frame, &frame, &pose), MLResult_Ok);
    EXPECT_NEAR(pose.transform.rotation.w, 1, 1e-6);
    EXPECT_NEAR(pose.transform.position.x, 0, 1e-6);
    EXPECT_EQ(pose.predict_time_ns, now);
}

TEST_F(Perception, AFailingSnapshotFails) {
    set("fault.snapshot.get", "1");
    MLSnapshot *snapshot = nullptr;
    EXPECT_EQ(MLPerceptionGetSnapshot(&snapshot), MLResult_UnspecifiedFailure);
    EXPECT_EQ(snapshot, nullptr);
}

TEST_F(Perception, AFailingHeadTrackerIsNotCreated) {
    set("fault.head.create", "1");
    MLHandle second = 0;
    EXPECT_EQ(MLHeadTrackingCreate(&second), MLResult_UnspecifiedFailure);
    EXPECT_EQ(second, ML_INVALID_HANDLE);
}

TEST_F(Perception, LostAndFoundAgainAreEventsToldOnce) {
    MLTransform head;
    EXPECT_EQ(events(), 0u);
    set("fault.head.tracking", "1");
    EXPECT_EQ(state().status, uint32_t{MLHeadTrackingStatus_Relocalizing});
    EXPECT_EQ(state().error, uint32_t{MLHeadTrackingErrorFlag_NotEnoughFeatures});
    EXPECT_EQ(headAt(ml2sim_now_mltime(), &head), MLResult_PoseNotFound);
    EXPECT_EQ(events(), uint64_t{MLHeadTrackingMapEvent_Lost});
    EXPECT_EQ(events(), 0u);
    set("fault.head.tracking", "2");
    EXPECT_EQ(state().status, uint32_t{MLHeadTrackingStatus_Invalid});
    EXPECT_EQ(events(), 0u);
    set("fault.head.tracking", "0");
    EXPECT_EQ(events(), uint64_t{MLHeadTrackingMapEvent_Recovered});
    EXPECT_EQ(headAt(ml2sim_now_mltime(), &head), MLResult_Ok);
}

TEST_F(Perception, ANewSessionMovesTheOriginToTheHeadAndKeepsGravity) {
    set("fault.head.new_session", "1");
    EXPECT_EQ(events(), uint64_t{MLHeadTrackingMapEvent_NewSession});
    MLTransform head;
    ASSERT_EQ(headAt(ml2sim_now_mltime(), &head), MLResult_Ok);
    EXPECT_NEAR(head.position.x, 0, 1e-6);
    EXPECT_NEAR(head.position.y, 0, 1e-6);
    EXPECT_NEAR(head.position.z, 0, 1e-6);
    // Forward has no sideways part left; tilt remains.
    const auto &q = head.rotation;
    EXPECT_NEAR(2 * (q.x * q.z + q.w * q.y), 0, 1e-6);
    float accel[3];
    ml2sim_imu(ML2SIM_HEADSET_LEFT, ml2sim_now_boottime(), accel, nullptr, nullptr);
    EXPECT_GT(accel[1], 5) << "up stays up";
}

TEST_F(Perception, ANewSessionWhileLostIsAFailedRecovery) {
    set("fault.head.tracking", "2");
    set("fault.head.new_session", "1");
    EXPECT_EQ(events(), uint64_t{MLHeadTrackingMapEvent_Lost | MLHeadTrackingMapEvent_RecoveryFailed |
                                 MLHeadTrackingMapEvent_NewSession});
}

TEST_F(Perception, EveryTrackerIsToldOfEventsSinceItsCreation) {
    set("fault.head.new_session", "1");
    MLHandle second = 0;
    ASSERT_EQ(MLHeadTrackingCreate(&second), MLResult_Ok);
    uint64_t told = 0;
    EXPECT_EQ(MLHeadTrackingGetMapEvents(second, &told), MLResult_Ok);
    EXPECT_EQ(told, 0u);
    EXPECT_EQ(events(), uint64_t{MLHeadTrackingMapEvent_NewSession});
    MLHeadTrackingDestroy(second);
}

TEST_F(Perception, AClosedTrackerIsRefused) {
    MLHandle second = 0;
    ASSERT_EQ(MLHeadTrackingCreate(&second), MLResult_Ok);
    EXPECT_EQ(MLHeadTrackingDestroy(second), MLResult_Ok);
    EXPECT_EQ(MLHeadTrackingDestroy(second), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_HANDLE);
}

class ColorPose : public Perception {
  protected:
    void SetUp() override {
        Perception::SetUp();
        ASSERT_EQ(MLCVCameraTrackingCreate(&cv), MLResult_Ok);
    }
    void TearDown() override {
        MLCVCameraTrackingDestroy(cv);
        Perception::TearDown();
    }
    MLResult poseAt(MLTime time) { return MLCVCameraGetFramePose(cv, tracker, MLCVCameraID_ColorCamera, time, &pose); }

    MLHandle cv = ML_INVALID_HANDLE;
    MLTransform pose;
};

TEST_F(ColorPose, IsThatOfTheCameraAtTheTime) {
    const auto time = ml2sim_now_mltime() - 30 * kMillisecond;
    ASSERT_EQ(poseAt(time), MLResult_Ok);
    ml2sim_pose truth;
    ml2sim_true_pose(ML2SIM_COLOR, time, &truth);
    expectEqual(pose, truth);
}

TEST_F(ColorPose, IsNotFoundOutsideTheShortHistory) {
    EXPECT_EQ(poseAt(ml2sim_now_mltime() - 501 * kMillisecond), MLResult_PoseNotFound);
    EXPECT_EQ(poseAt(ml2sim_now_mltime() + 1), MLResult_PoseNotFound);
}

TEST_F(ColorPose, NeedsAHeadTrackerThatIsOpen) {
    EXPECT_EQ(MLCVCameraGetFramePose(cv, 77, MLCVCameraID_ColorCamera, ml2sim_now_mltime(), &pose),
              MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_HANDLE);
}

TEST_F(ColorPose, IsNotFoundWhileLostOrByFault) {
    set("fault.color.pose", "1");
    EXPECT_EQ(poseAt(ml2sim_now_mltime()), MLResult_PoseNotFound);
    set("fault.color.pose", "0");
    set("fault.head.tracking", "1");
    EXPECT_EQ(poseAt(ml2sim_now_mltime()), MLResult_PoseNotFound);
}

TEST_F(ColorPose, IsDeniedWithoutPermission) {
    set("fault.color.permission", "1");
    MLHandle second = 0;
    EXPECT_EQ(MLCVCameraTrackingCreate(&second), MLResult_PermissionDenied);
    EXPECT_EQ(second, ML_INVALID_HANDLE);
}

TEST(Results, HaveNames) {
    EXPECT_STREQ(MLGlobalGetResultString(12), "MLResult_PerceptionSystemNotStarted");
    EXPECT_STREQ(MLGlobalGetResultString(99), "MLResult_Unknown");
    EXPECT_STREQ(MLSnapshotGetResultString(MLSnapshotResult_DerivativesNotCalculated),
                 "MLSnapshotResult_DerivativesNotCalculated");
}
