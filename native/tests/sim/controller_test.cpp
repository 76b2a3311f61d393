// MLController* and MLInput*: what they refuse, and that their frames have poses only while they are known.
#include "input.h"
#include "ml_controller.h"
#include "ml_unused.h"
#include "perception_fixture.h"

class SimulatedController : public TrackedHeadset {
  protected:
    void SetUp() override {
        TrackedHeadset::SetUp();
        ASSERT_EQ(MLControllerCreateEx(&modes, &controller), MLResult_Ok);
        ml2sim_advance(kSecond);
    }
    void TearDown() override {
        MLControllerDestroy(controller);
        TrackedHeadset::TearDown();
    }
    MLControllerStateEx state() {
        auto out = initialised(MLControllerSystemStateExInit);
        EXPECT_EQ(MLControllerGetStateEx(controller, &out), MLResult_Ok);
        return out.controller_state[0];
    }

    const MLControllerConfiguration modes = {false, false, true};
    MLHandle controller = ML_INVALID_HANDLE;
};

TEST_F(SimulatedController, BothOfItsFramesHaveThePoseWhileItIsActive) {
    MLTransform smooth, raw;
    EXPECT_EQ(state().status, uint32_t{MLControllerStatus_Active});
    ASSERT_EQ(Snapshot().find(state().coord_frame_controller, &smooth), MLResult_Ok);
    ASSERT_EQ(Snapshot().find(state().raw_coord_frame_controller, &raw), MLResult_Ok);
    EXPECT_EQ(smooth.position.y, raw.position.y);
    set("fault.controller.tracking", "2");
    EXPECT_EQ(state().status, uint32_t{MLControllerStatus_NotActive});
    EXPECT_EQ(Snapshot().find(state().coord_frame_controller, &smooth), MLResult_PoseNotFound);
}

TEST_F(SimulatedController, ATrackerNeedsTheModeThatIsNotDeprecated) {
    const MLControllerConfiguration none = {true, true, false};
    MLHandle second = 0;
    EXPECT_EQ(MLControllerCreateEx(&none, &second), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT);
}

TEST_F(SimulatedController, AnotherVersionIsRefused) {
    MLControllerSystemStateEx out = {};
    EXPECT_EQ(MLControllerGetStateEx(controller, &out), MLResult_InvalidParam);
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
