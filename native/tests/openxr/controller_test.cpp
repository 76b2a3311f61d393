// The controller. Through OpenXR it shares one attached action set with gaze.
#include "trackers.h"

namespace {

class Controller : public EitherBackend {
  protected:
    const ml2s_settings pose = by(kController), input = by(kControllerInput);
};

/** What only OpenXR has. */
using OpenXrController = OpenXr;
/** What only the vendor's interface has. */
using SdkController = Trackers;

} // namespace

INSTANTIATE_TEST_SUITE_P(By, Controller, kEither, nameOf);

TEST_P(Controller, ThePoseIsThatOfTheInstantOfItsStamp) {
    Sensor sensor(pose);
    tracked(sensor);
    const int64_t before = ml2s_now();
    const auto found = sensor.pollPose();
    EXPECT_EQ(found.stream, uint32_t{ML2S_STREAM_CONTROLLER});
    expectNow(before, found.capture_nanos, found.device_nanos);
    expectAt(found, ml2sim::controllerInHead(found.device_nanos));
}

TEST_P(Controller, ButtonsTriggerAndTouchpadAreThoseOfTheInstant) {
    stopTime();
    Sensor sensor(input);
    for (int i = 0; i < 12; i++) {
        const auto found = sensor.pollInput();
        ASSERT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        const auto truth = ml2sim::controllerInputAt(ml2sim_now_mltime());
        EXPECT_TRUE(found.is_connected);
        EXPECT_EQ(found.bumper, truth.bumper ? 1u : 0u);
        EXPECT_EQ(found.menu, truth.menu ? 1u : 0u);
        EXPECT_EQ(found.is_touched, truth.isTouched ? 1u : 0u);
        EXPECT_FLOAT_EQ(found.trigger, truth.trigger);
        EXPECT_FLOAT_EQ(found.touch[0], truth.x);
        EXPECT_FLOAT_EQ(found.touch[1], truth.y);
        EXPECT_FLOAT_EQ(found.force, truth.force);
        ml2sim_advance(350 * kMillisecond);
    }
}

TEST_P(Controller, InputIsStampedWithTheInstantOfThePoll) {
    Sensor sensor(input);
    const int64_t before = ml2s_now();
    const auto found = sensor.pollInput();
    expectNow(before, found.capture_nanos, found.device_nanos);
}

TEST_P(Controller, AControllerOfWhichOnlyTheRotationIsKnownIsUntracked) {
    Sensor sensor(pose);
    tracked(sensor);
    for (const char *state : {"1", "2"}) {
        headset("fault.controller.tracking", state);
        EXPECT_FALSE(sensor.pollPose().is_tracked) << state;
        EXPECT_EQ(sensor.result, ML2S_OK);
    }
    headset("fault.controller.tracking", "0");
    EXPECT_TRUE(sensor.pollPose().is_tracked);
}

TEST_P(Controller, AnUntrackedHeadsetTracksNoController) {
    Sensor sensor(pose);
    tracked(sensor);
    headset("fault.head.tracking", "1");
    EXPECT_FALSE(sensor.pollPose().is_tracked);
    EXPECT_EQ(sensor.result, ML2S_OK);
}

TEST_P(Controller, AControllerThatIsNotConnectedHasNothingPressed) {
    headset("fault.input.disconnected", "1");
    Sensor sensor(input);
    const auto found = sensor.pollInput();
    EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    EXPECT_GT(found.capture_nanos, 0);
    EXPECT_EQ(found.is_connected + found.bumper + found.menu + found.is_touched, 0u);
    EXPECT_EQ(found.trigger, 0);
}

TEST_P(Controller, PosesAreNotToBeHadFromTheButtonsNorButtonsFromThePose) {
    Sensor posed(pose), pressed(input);
    posed.pollInput();
    EXPECT_EQ(posed.result, ML2S_INVALID_ARGUMENT);
    pressed.pollPose();
    EXPECT_EQ(pressed.result, ML2S_INVALID_ARGUMENT);
}

TEST_F(SdkController, ATriggerThatIsNoNumberFailsThePoll) {
    headset("fault.input.unusable", "1");
    Sensor sensor(onSdk(kControllerInput));
    sensor.pollInput();
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message,
                 "MLInputGetControllerStateEx: trigger or touch is not a number, expected -1 to 1");
}

TEST_F(OpenXrController, GazeAndControllerOpenInAnyOrderAndAgain) {
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

TEST_F(OpenXrController, WithoutTheExtensionOnlyTheControllerIsRefused) {
    runtime("fault.extension.missing", "XR_ML_ml2_controller_interaction");
    expectRefused(kController, ML2S_NOT_AVAILABLE, "not available: XR_ML_ml2_controller_interaction");
    expectRefused(kControllerInput, ML2S_NOT_AVAILABLE, "not available: XR_ML_ml2_controller_interaction");
    Sensor gaze(kGaze);
    EXPECT_TRUE(gaze.pollPose().is_tracked);
}

TEST_F(OpenXrController, WithoutTheExtensionOfGazeTheControllerWorks) {
    runtime("fault.extension.missing", "XR_EXT_eye_gaze_interaction");
    Sensor controller(kController);
    EXPECT_TRUE(controller.pollPose().is_tracked);
}

TEST_F(OpenXrController, BindingsThatTheRuntimeRefusesTakeTheirOwnStreamsOnly) {
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
