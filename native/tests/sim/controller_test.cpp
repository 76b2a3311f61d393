// MLController* and MLInput*: what they refuse, and that their frames have poses only while they are known.
#include "headset.h"
#include "input.h"
#include "ml_controller.h"
#include "ml_unused.h"

class SimulatedController : public SimulatedHeadset {
  protected:
    void SetUp() override {
        SimulatedHeadset::SetUp();
        MLPerceptionSettings settings;
        MLPerceptionInitSettings(&settings);
        ASSERT_EQ(MLPerceptionStartup(&settings), MLResult_Ok);
        MLSnapshot *first = nullptr;
        ASSERT_EQ(MLPerceptionGetSnapshot(&first), MLResult_Ok);
        MLPerceptionReleaseSnapshot(first);
        ASSERT_EQ(MLHeadTrackingCreate(&head), MLResult_Ok);
        ASSERT_EQ(MLControllerCreateEx(&modes, &tracker), MLResult_Ok);
        ml2sim_advance(kSecond);
    }
    void TearDown() override {
        MLControllerDestroy(tracker);
        MLHeadTrackingDestroy(head);
        MLPerceptionShutdown();
        SimulatedHeadset::TearDown();
    }
    MLControllerStateEx state() {
        MLControllerSystemStateEx out;
        MLControllerSystemStateExInit(&out);
        EXPECT_EQ(MLControllerGetStateEx(tracker, &out), MLResult_Ok);
        return out.controller_state[0];
    }
    static MLResult poseOf(const MLCoordinateFrameUID &frame, MLTransform *out) {
        MLSnapshot *snapshot = nullptr;
        EXPECT_EQ(MLPerceptionGetSnapshot(&snapshot), MLResult_Ok);
        const auto result = MLSnapshotGetTransform(snapshot, &frame, out);
        MLPerceptionReleaseSnapshot(snapshot);
        return result;
    }

    const MLControllerConfiguration modes = {false, false, true};
    MLHandle head = ML_INVALID_HANDLE;
    MLHandle tracker = ML_INVALID_HANDLE;
};

TEST_F(SimulatedController, BothOfItsFramesHaveThePoseWhileItIsActive) {
    MLTransform smooth, raw;
    EXPECT_EQ(state().status, uint32_t{MLControllerStatus_Active});
    ASSERT_EQ(poseOf(state().coord_frame_controller, &smooth), MLResult_Ok);
    ASSERT_EQ(poseOf(state().raw_coord_frame_controller, &raw), MLResult_Ok);
    EXPECT_EQ(smooth.position.y, raw.position.y);
    set("fault.controller.tracking", "2");
    EXPECT_EQ(state().status, uint32_t{MLControllerStatus_NotActive});
    EXPECT_EQ(poseOf(state().coord_frame_controller, &smooth), MLResult_PoseNotFound);
}

TEST_F(SimulatedController, ATrackerNeedsTheModeThatIsNotDeprecated) {
    const MLControllerConfiguration none = {true, true, false};
    MLHandle second = 0;
    EXPECT_EQ(MLControllerCreateEx(&none, &second), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT);
}

TEST_F(SimulatedController, AnotherVersionIsRefused) {
    MLControllerSystemStateEx out = {};
    EXPECT_EQ(MLControllerGetStateEx(tracker, &out), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_VERSION);
}

TEST_F(SimulatedController, InputNeedsNoPerceptionSystemButItsVersionAndAnOpenTracker) {
    MLHandle input = 0;
    ASSERT_EQ(ml2sim_MLInputCreate(&input), MLResult_Ok);
    MLInputControllerStateEx states[MLInput_MaxControllers];
    MLInputControllerStateExInit(states);
    EXPECT_EQ(ml2sim_MLInputGetControllerStateEx(input, states), MLResult_Ok);
    EXPECT_TRUE(states[0].is_connected);
    states[0].version = 0;
    EXPECT_EQ(ml2sim_MLInputGetControllerStateEx(input, states), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_VERSION);
    EXPECT_EQ(ml2sim_MLInputDestroy(input), MLResult_Ok);
    EXPECT_EQ(ml2sim_MLInputDestroy(input), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_HANDLE);
}
