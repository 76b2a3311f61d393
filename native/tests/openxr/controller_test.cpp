// The controller through OpenXR, which shares one attached action set with gaze.
#include "../../sim/eyes_and_hands.h"
#include "openxr_fixture.h"

namespace {

using Controller = OpenXr;

} // namespace

TEST_F(Controller, ThePoseMovesAsTheControllerDoes) {
    Sensor sensor(kController), head(kHead);
    const auto pose = sensor.pollPose();
    ASSERT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    EXPECT_TRUE(pose.is_tracked);
    EXPECT_EQ(pose.stream, uint32_t{ML2S_STREAM_CONTROLLER});
    ml2sim_pose truth;
    ml2sim_true_head(pose.device_nanos, &truth);
    const auto &q = truth.rotation;
    const auto expected = compose({{q[0], q[1], q[2], q[3]}, {truth.position[0], truth.position[1], truth.position[2]}},
                                  ml2sim::controllerInHead(pose.device_nanos));
    EXPECT_NEAR(pose.position[0], expected.position.x, 1e-5);
    EXPECT_NEAR(pose.position[1], expected.position.y, 1e-5);
    EXPECT_NEAR(pose.position[2], expected.position.z, 1e-5);
}

TEST_F(Controller, ButtonsTriggerAndTouchpadAreThoseOfTheInstant) {
    stopTime();
    Sensor sensor(kControllerInput);
    for (int i = 0; i < 12; i++) {
        const auto input = sensor.pollInput();
        ASSERT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        const auto truth = ml2sim::controllerInputAt(ml2sim_now_mltime());
        EXPECT_TRUE(input.is_connected);
        EXPECT_EQ(input.bumper, truth.bumper ? 1u : 0u);
        EXPECT_EQ(input.menu, truth.menu ? 1u : 0u);
        EXPECT_EQ(input.is_touched, truth.isTouched ? 1u : 0u);
        EXPECT_FLOAT_EQ(input.trigger, truth.trigger);
        EXPECT_FLOAT_EQ(input.touch[0], truth.x);
        EXPECT_FLOAT_EQ(input.touch[1], truth.y);
        EXPECT_FLOAT_EQ(input.force, truth.force);
        ml2sim_advance(350 * kMillisecond);
    }
}

TEST_F(Controller, GazeAndControllerOpenInAnyOrderAndAgain) {
    for (int i = 0; i < 2; i++) {
        const Sensor head(kHead);
        Sensor first(i ? kGaze : kController), second(i ? kController : kGaze), input(kControllerInput);
        EXPECT_TRUE(first.pollPose().is_tracked) << first.error.message;
        EXPECT_TRUE(second.pollPose().is_tracked) << second.error.message;
        EXPECT_TRUE(input.pollInput().is_connected) << input.error.message;
        EXPECT_EQ(first.close(), ML2S_OK);
        Sensor again(i ? kGaze : kController);
        EXPECT_TRUE(again.pollPose().is_tracked) << again.error.message;
    }
}

TEST_F(Controller, WithoutTheExtensionOnlyTheControllerIsRefused) {
    runtime("fault.extension.missing", "XR_ML_ml2_controller_interaction");
    expectRefused(kController, ML2S_NOT_AVAILABLE, "not available: XR_ML_ml2_controller_interaction");
    expectRefused(kControllerInput, ML2S_NOT_AVAILABLE, "not available: XR_ML_ml2_controller_interaction");
    Sensor gaze(kGaze);
    EXPECT_TRUE(gaze.pollPose().is_tracked);
}

TEST_F(Controller, WithoutTheExtensionOfGazeTheControllerWorks) {
    runtime("fault.extension.missing", "XR_EXT_eye_gaze_interaction");
    Sensor controller(kController);
    EXPECT_TRUE(controller.pollPose().is_tracked);
}

TEST_F(Controller, BindingsThatTheRuntimeRefusesTakeTheirOwnStreamsOnly) {
    const std::string reason = "xrSuggestInteractionProfileBindings: XR_ERROR_PATH_UNSUPPORTED (-22)";
    {
        runtime("fault.profile.refused", "/interaction_profiles/ml/ml2_controller");
        const Sensor head(kHead);
        Sensor gaze(kGaze);
        expectRefused(kController, ML2S_VENDOR_FAILURE, reason);
        expectRefused(kControllerInput, ML2S_VENDOR_FAILURE, reason);
        EXPECT_TRUE(gaze.pollPose().is_tracked) << gaze.error.message;
    }
    runtime("fault.profile.refused", "/interaction_profiles/ext/eye_gaze_interaction");
    const Sensor head(kHead);
    expectRefused(kGaze, ML2S_VENDOR_FAILURE, reason);
    Sensor controller(kController);
    EXPECT_TRUE(controller.pollPose().is_tracked) << controller.error.message;
}

TEST_F(Controller, AControllerThatIsNotConnectedHasNothingPressed) {
    headset("fault.input.disconnected", "1");
    headset("fault.controller.tracking", "2");
    Sensor pose(kController), sensor(kControllerInput);
    EXPECT_FALSE(pose.pollPose().is_tracked);
    const auto input = sensor.pollInput();
    EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    EXPECT_EQ(input.is_connected + input.bumper + input.menu + input.is_touched, 0u);
}
