// The controller. Through OpenXR it shares one attached action set with gaze.
#include "trackers.h"

namespace {

class Controller : public EitherBackend {
  protected:
    const ml2s_settings pose = by(kController), input = by(kControllerInput);
};

/** Tests of OpenXR alone. */
using OpenXrController = OpenXr;
/** Tests of the vendor's interface alone. */
using SdkController = Trackers;

} // namespace

INSTANTIATE_TEST_SUITE_P(By, Controller, kEither, nameOf);

TEST_P(Controller, ThePoseIsThatOfTheInstantOfItsStamp) {
    Sensor sensor(pose);
    tracked(sensor);
    const int64_t before = ml2s_now();
    const auto found = sensor.pollReading();
    EXPECT_EQ(found.stream, uint32_t{ML2S_STREAM_CONTROLLER});
    expectNow(before, found.capture_nanos, found.device_nanos);
    expectAt(found, ml2sim::controllerInHead(found.device_nanos));
}

TEST_P(Controller, ButtonsTriggerAndTouchpadAreThoseOfTheInstant) {
    stopTime();
    Sensor sensor(input);
    for (int i = 0; i < 12; i++) {
        const auto found = sensor.pollReading();
        ASSERT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        const auto truth = ml2sim::controllerInputAt(ml2sim_now_mltime());
        EXPECT_TRUE(found.is_tracked);
        EXPECT_EQ(found.values[ML2S_INPUT_BUMPER], truth.bumper ? 1 : 0);
        EXPECT_EQ(found.values[ML2S_INPUT_MENU], truth.menu ? 1 : 0);
        EXPECT_EQ(found.values[ML2S_INPUT_TOUCHED], truth.isTouched ? 1 : 0);
        EXPECT_FLOAT_EQ(found.values[ML2S_INPUT_TRIGGER], truth.trigger);
        EXPECT_FLOAT_EQ(found.values[ML2S_INPUT_TOUCH_X], truth.x);
        EXPECT_FLOAT_EQ(found.values[ML2S_INPUT_TOUCH_Y], truth.y);
        EXPECT_FLOAT_EQ(found.values[ML2S_INPUT_FORCE], truth.force);
        ml2sim_advance(350 * kMillisecond);
    }
}

TEST_P(Controller, InputIsStampedWithTheInstantOfThePoll) {
    Sensor sensor(input);
    const int64_t before = ml2s_now();
    const auto found = sensor.pollReading();
    expectNow(before, found.capture_nanos, found.device_nanos);
}

TEST_P(Controller, AControllerOfWhichOnlyTheRotationIsKnownIsUntracked) {
    Sensor sensor(pose);
    tracked(sensor);
    for (const char *state : {"1", "2"}) {
        headset("fault.controller.tracking", state);
        EXPECT_FALSE(sensor.pollReading().is_tracked) << state;
        EXPECT_EQ(sensor.result, ML2S_OK);
    }
    headset("fault.controller.tracking", "0");
    EXPECT_TRUE(sensor.pollReading().is_tracked);
}

TEST_P(Controller, AnUntrackedHeadsetTracksNoController) {
    Sensor sensor(pose);
    tracked(sensor);
    headset("fault.head.tracking", "1");
    EXPECT_FALSE(sensor.pollReading().is_tracked);
    EXPECT_EQ(sensor.result, ML2S_OK);
}

TEST_P(Controller, AControllerThatIsNotConnectedHasNothingPressed) {
    headset("fault.input.disconnected", "1");
    Sensor sensor(input);
    const auto found = sensor.pollReading();
    EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    EXPECT_GT(found.capture_nanos, 0);
    EXPECT_FALSE(found.is_tracked);
    for (const float value : found.values) {
        EXPECT_EQ(value, 0);
    }
}

TEST_F(SdkController, ATriggerThatIsNoNumberFailsThePoll) {
    headset("fault.input.unusable", "1");
    Sensor sensor(onSdk(kControllerInput));
    sensor.pollReading();
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message,
                 "MLInputGetControllerStateEx: trigger or touch is not a number, expected -1 to 1");
}

TEST_F(OpenXrController, GazeAndControllerOpenInAnyOrderAndAgain) {
    for (int i = 0; i < 2; i++) {
        const Sensor head(kHead);
        Sensor first(i ? kGaze : kController), second(i ? kController : kGaze), input(kControllerInput);
        EXPECT_TRUE(first.pollReading().is_tracked) << first.error.message;
        EXPECT_TRUE(second.pollReading().is_tracked) << second.error.message;
        EXPECT_TRUE(input.pollReading().is_tracked) << input.error.message;
        EXPECT_EQ(first.close(), ML2S_OK);
        Sensor again(i ? kGaze : kController);
        EXPECT_TRUE(again.pollReading().is_tracked) << again.error.message;
    }
}

TEST_F(OpenXrController, WithoutTheExtensionOnlyTheControllerIsRefused) {
    runtime("fault.extension.missing", "XR_ML_ml2_controller_interaction");
    expectRefused(kController, ML2S_NOT_AVAILABLE, "not available: XR_ML_ml2_controller_interaction");
    expectRefused(kControllerInput, ML2S_NOT_AVAILABLE, "not available: XR_ML_ml2_controller_interaction");
    Sensor gaze(kGaze);
    EXPECT_TRUE(gaze.pollReading().is_tracked);
}

TEST_F(OpenXrController, WithoutTheExtensionOfGazeTheControllerWorks) {
    runtime("fault.extension.missing", "XR_EXT_eye_gaze_interaction");
    Sensor controller(kController);
    EXPECT_TRUE(controller.pollReading().is_tracked);
}

TEST_F(OpenXrController, BindingsThatTheRuntimeRefusesTakeTheirOwnStreamsOnly) {
    const std::string reason = "xrSuggestInteractionProfileBindings: XR_ERROR_PATH_UNSUPPORTED (-22)";
    {
        runtime("fault.profile.refused", "/interaction_profiles/ml/ml2_controller");
        const Sensor head(kHead);
        Sensor gaze(kGaze);
        expectRefused(kController, ML2S_VENDOR_FAILURE, reason);
        expectRefused(kControllerInput, ML2S_VENDOR_FAILURE, reason);
        EXPECT_TRUE(gaze.pollReading().is_tracked) << gaze.error.message;
    }
    runtime("fault.profile.refused", "/interaction_profiles/ext/eye_gaze_interaction");
    const Sensor head(kHead);
    expectRefused(kGaze, ML2S_VENDOR_FAILURE, reason);
    Sensor controller(kController);
    EXPECT_TRUE(controller.pollReading().is_tracked) << controller.error.message;
}
