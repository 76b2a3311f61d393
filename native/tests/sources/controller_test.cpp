// The controller against the simulated headset.
#include <chrono>
#include <cmath>

#include "eyes_and_hands.h"
#include "leak_check.h"

namespace {

const auto kPose = settingsOf(ML2S_SENSOR_CONTROLLER, ML2S_STREAM_BIT(ML2S_STREAM_CONTROLLER));
const auto kInput = settingsOf(ML2S_SENSOR_CONTROLLER_INPUT, ML2S_STREAM_BIT(ML2S_STREAM_CONTROLLER_JOY));

class Controller : public LeakCheck {
  protected:
    /** Once tracking has begun. */
    static ml2s_pose tracked(Sensor &sensor) {
        auto pose = sensor.pollPose();
        while (sensor.result == ML2S_OK && !pose.is_tracked) {
            pose = sensor.pollPose();
        }
        EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        return pose;
    }
};

} // namespace

TEST_F(Controller, ThePoseIsThatOfTheInstantOfItsStamp) {
    Sensor sensor(kPose);
    const auto pose = tracked(sensor);
    ml2sim_pose head;
    ml2sim_true_head(pose.device_nanos, &head);
    const auto &q = head.rotation;
    const auto truth = compose({{q[0], q[1], q[2], q[3]}, {head.position[0], head.position[1], head.position[2]}},
                               ml2sim::controllerInHead(pose.device_nanos));
    const auto *r = pose.rotation;
    EXPECT_EQ(pose.stream, uint32_t{ML2S_STREAM_CONTROLLER});
    EXPECT_NEAR(std::fabs(truth.rotation.x * r[0] + truth.rotation.y * r[1] + truth.rotation.z * r[2] +
                          truth.rotation.w * r[3]),
                1, 1e-6);
    EXPECT_NEAR(pose.position[0], truth.position.x, 1e-5);
    EXPECT_NEAR(pose.position[1], truth.position.y, 1e-5);
    EXPECT_NEAR(pose.position[2], truth.position.z, 1e-5);
    EXPECT_NEAR(static_cast<double>(pose.capture_nanos - ml2sim_boottime_of_mltime(pose.device_nanos)), 0, 50000);
}

TEST_F(Controller, AControllerOfWhichOnlyTheRotationIsKnownIsUntracked) {
    Sensor sensor(kPose);
    tracked(sensor);
    for (const char *state : {"1", "2"}) {
        set("fault.controller.tracking", state);
        EXPECT_FALSE(sensor.pollPose().is_tracked) << state;
        EXPECT_EQ(sensor.result, ML2S_OK);
    }
    set("fault.controller.tracking", "0");
    EXPECT_TRUE(sensor.pollPose().is_tracked);
}

TEST_F(Controller, AnUntrackedHeadsetTracksNoController) {
    Sensor sensor(kPose);
    tracked(sensor);
    set("fault.head.tracking", "1");
    EXPECT_FALSE(sensor.pollPose().is_tracked);
    EXPECT_EQ(sensor.result, ML2S_OK);
}

TEST_F(Controller, WithoutPermissionNothingIsLeftOpen) {
    set("fault.controller.permission", "1");
    const Sensor sensor(kPose);
    EXPECT_EQ(sensor.result, ML2S_PERMISSION_DENIED);
    EXPECT_STREQ(sensor.error.message, "MLControllerCreateEx: PermissionDenied (7)");
}

TEST_F(Controller, ButtonsTriggerAndTouchpadAreThoseOfTheInstant) {
    Sensor sensor(kInput);
    uint32_t polls[2] = {0, 0};
    while (!polls[0] || !polls[1]) { // half a second
        const auto start = std::chrono::steady_clock::now();
        const auto input = sensor.pollInput();
        ASSERT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
        if (std::chrono::steady_clock::now() - start > std::chrono::milliseconds(5)) {
            continue; // On a busy machine, the state can be read long before the time.
        }
        const auto truth = ml2sim::controllerInputAt(input.device_nanos);
        const auto before = ml2sim::controllerInputAt(input.device_nanos - 20000000);
        if (truth.bumper != before.bumper) {
            continue; // The state is read a moment before the time.
        }
        polls[input.bumper]++;
        EXPECT_TRUE(input.is_connected);
        EXPECT_EQ(input.bumper, truth.bumper ? 1u : 0u);
        EXPECT_EQ(input.menu, truth.menu ? 1u : 0u);
        EXPECT_EQ(input.is_touched, truth.isTouched ? 1u : 0u);
        EXPECT_NEAR(input.trigger, truth.trigger, 0.02);
        EXPECT_NEAR(input.touch[0], truth.x, 0.02);
        EXPECT_NEAR(input.touch[1], truth.y, 0.02);
        EXPECT_EQ(input.force, truth.force);
        EXPECT_NEAR(static_cast<double>(input.capture_nanos - ml2sim_boottime_of_mltime(input.device_nanos)), 0, 50000);
    }
}

TEST_F(Controller, AControllerThatIsNotConnectedHasNothingPressed) {
    set("fault.input.disconnected", "1");
    Sensor sensor(kInput);
    const auto input = sensor.pollInput();
    EXPECT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    EXPECT_GT(input.capture_nanos, 0);
    EXPECT_EQ(input.is_connected + input.bumper + input.menu + input.is_touched, 0u);
    EXPECT_EQ(input.trigger, 0);
}

TEST_F(Controller, ATriggerThatIsNoNumberFailsThePoll) {
    set("fault.input.unusable", "1");
    Sensor sensor(kInput);
    sensor.pollInput();
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message,
                 "MLInputGetControllerStateEx: trigger or touch is not a number, expected -1 to 1");
}

TEST_F(Controller, AnInputTrackerThatCannotBeCreatedIsNamed) {
    set("fault.input.create", "1");
    const Sensor sensor(kInput);
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message, "MLInputCreate: UnspecifiedFailure (4)");
}

TEST_F(Controller, APausedControllerIsGivenBackAndTakenAgain) {
    Sensor pose(kPose), input(kInput);
    EXPECT_EQ(pose.pause(), ML2S_OK);
    EXPECT_EQ(input.pause(), ML2S_OK);
    ml2sim_counters counters;
    ml2sim_get_counters(&counters);
    EXPECT_EQ(counters.open_handles, 0u);
    input.pollInput();
    EXPECT_EQ(input.result, ML2S_TIMEOUT);
    EXPECT_EQ(pose.resume(), ML2S_OK);
    EXPECT_EQ(input.resume(), ML2S_OK);
    tracked(pose);
    EXPECT_TRUE(input.pollInput().is_connected);
}

TEST_F(Controller, PosesAreNotToBeHadFromTheButtonsNorButtonsFromThePose) {
    Sensor pose(kPose), input(kInput);
    pose.pollInput();
    EXPECT_EQ(pose.result, ML2S_INVALID_ARGUMENT);
    input.pollPose();
    EXPECT_EQ(input.result, ML2S_INVALID_ARGUMENT);
}
