#include <algorithm>
#include <thread>

#include "scripted_sdk.h"
#include "sensor.h"

using scripted::script;

namespace {

constexpr uint64_t kDepth = ML2S_STREAM_BIT(ML2S_STREAM_DEPTH);
constexpr uint64_t kHead = ML2S_STREAM_BIT(ML2S_STREAM_HEAD_POSE);
constexpr uint64_t kLeft = ML2S_STREAM_BIT(ML2S_STREAM_WORLD_LEFT);

class Handles : public testing::Test {
  protected:
    Handles() {
        script = {};
        script.transform = {{0, 0, 0, 1}, {1, 2, 3}};
    }
    const ml2s_settings head = settingsOf(ML2S_SENSOR_HEAD, kHead);
    const ml2s_settings depth = settingsOf(ML2S_SENSOR_DEPTH, kDepth);

    static ml2s_result open(const ml2s_settings &settings) { return Sensor(settings).result; }
};

/** A thread to which the vendor does not return from a function, until the end. */
class Stuck {
  public:
    template <class Action> Stuck(const std::string &function, Action action) {
        scripted::blocking = function;
        scripted::isBlocked = false;
        sem_init(&scripted::blocked, 0, 0);
        sem_init(&scripted::released, 0, 0);
        thread_ = std::thread(action);
        sem_wait(&scripted::blocked);
    }
    ~Stuck() {
        sem_post(&scripted::released);
        thread_.join();
        scripted::blocking.clear();
    }

  private:
    std::thread thread_;
};

} // namespace

TEST_F(Handles, ASensorIsOpenOnceAndAgainAfterItWasClosed) {
    Sensor first(head);
    ASSERT_EQ(first.result, ML2S_OK);
    const Sensor second(head);
    EXPECT_EQ(second.result, ML2S_BUSY);
    EXPECT_STREQ(second.error.message, "the sensor head is open already: close it first");
    EXPECT_EQ(first.close(), ML2S_OK);
    EXPECT_EQ(open(head), ML2S_OK);
}

TEST_F(Handles, AClosedHandleStaysClosedThoughItsSensorIsOpenedAgain) {
    Sensor first(head);
    EXPECT_EQ(first.close(), ML2S_OK);
    const Sensor second(head);
    ASSERT_EQ(second.result, ML2S_OK);
    first.pollReading();
    EXPECT_EQ(first.result, ML2S_CLOSED);
    EXPECT_EQ(first.close(), ML2S_CLOSED);
    EXPECT_EQ(ml2s_close(0, nullptr), ML2S_CLOSED);
    EXPECT_EQ(ml2s_close(UINT64_MAX, nullptr), ML2S_CLOSED);
}

TEST_F(Handles, OtherThreadsAreTurnedAwayFromEveryCall) {
    Sensor sensor(head);
    const size_t calls = script.calls.size();
    std::thread([&] {
        sensor.pollReading();
        EXPECT_EQ(sensor.result, ML2S_WRONG_THREAD);
        EXPECT_EQ(std::string(sensor.error.message).rfind("the handle was opened by thread ", 0), 0u);
        sensor.poll();
        EXPECT_EQ(sensor.result, ML2S_WRONG_THREAD);
        sensor.colorPose(0);
        EXPECT_EQ(sensor.result, ML2S_WRONG_THREAD);
        EXPECT_EQ(sensor.configure(settingsOf(ML2S_SENSOR_HEAD, kHead)), ML2S_WRONG_THREAD);
        EXPECT_EQ(sensor.close(), ML2S_WRONG_THREAD);
    }).join();
    EXPECT_EQ(script.calls.size(), calls);
    EXPECT_EQ(sensor.close(), ML2S_OK);
}

TEST_F(Handles, SettingsThatMakeNoSenseAreRefused) {
    const ml2s_settings senseless[] = {
        settingsOf(ML2S_SENSOR_DEPTH, 0),
        settingsOf(ML2S_SENSOR_DEPTH, kHead),
        settingsOf(ML2S_SENSOR_DEPTH, kDepth | UINT64_C(1) << 63),
        settingsOf(ML2S_SENSOR_WORLD, kLeft, kLeft << 1),
        settingsOf(static_cast<ml2s_sensor>(0), kHead),
        settingsOf(static_cast<ml2s_sensor>(8), kHead),
    };
    for (const auto &settings : senseless) {
        EXPECT_EQ(open(settings), ML2S_INVALID_ARGUMENT);
    }
    auto settings = head;
    settings.backend = 2;
    EXPECT_EQ(open(settings), ML2S_INVALID_ARGUMENT);
    settings = head;
    settings.struct_size = offsetof(ml2s_settings, marker_type) - 1;
    EXPECT_EQ(open(settings), ML2S_INVALID_ARGUMENT);
    EXPECT_TRUE(script.calls.empty());
}

TEST_F(Handles, AnErrorWithoutRoomForAMessageIsRefused) {
    ml2s_error error = {};
    ml2s_handle handle;
    EXPECT_EQ(ml2s_open(&head, &handle, &error), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_close(1, &error), ML2S_INVALID_ARGUMENT);
}

TEST_F(Handles, CheckingASensorTouchesNothing) {
    EXPECT_EQ(ml2s_check(ML2S_SENSOR_DEPTH, ML2S_BACKEND_SDK, nullptr), ML2S_OK);
    EXPECT_EQ(ml2s_check(0, ML2S_BACKEND_SDK, nullptr), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_check(ML2S_SENSOR_DEPTH, 2, nullptr), ML2S_INVALID_ARGUMENT);
    EXPECT_TRUE(script.calls.empty());
}

TEST_F(Handles, AHandleKeepsItsSensor) {
    Sensor sensor(head);
    EXPECT_EQ(sensor.configure(depth), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(sensor.configure(head), ML2S_OK);
}

TEST_F(Handles, CallersThatKnowMoreFieldsGetTheirsSpacedAsTheyAre) {
    struct Wider {
        ml2s_reading pose;
        uint64_t later;
    } poses[2] = {};
    poses[0].pose.struct_size = sizeof(Wider);
    poses[1].later = 77;
    Sensor sensor(head);
    uint32_t count = 0;
    EXPECT_EQ(ml2s_poll_readings(sensor.handle(), &poses[0].pose, 2, &count, nullptr), ML2S_OK);
    EXPECT_EQ(count, 1u);
    EXPECT_EQ(poses[0].pose.struct_size, sizeof(Wider));
    EXPECT_EQ(poses[0].pose.stream, ML2S_STREAM_HEAD_POSE);
    EXPECT_EQ(poses[1].later, 77u);
    poses[0].pose.struct_size = sizeof(ml2s_reading) - 1;
    EXPECT_EQ(ml2s_poll_readings(sensor.handle(), &poses[0].pose, 2, &count, nullptr), ML2S_INVALID_ARGUMENT);
}

TEST_F(Handles, ThePerceptionSystemIsStartedOnceAndRunsOnForOthersAfterTheLastSensor) {
    for (int i = 0; i < 2; i++) {
        const Sensor first(head);
        const Sensor second(depth);
        EXPECT_EQ(second.result, ML2S_OK);
    }
    EXPECT_EQ(script.countOf("MLPerceptionStartup"), 1);
    EXPECT_TRUE(script.isPerceptionStarted) << "another library in the process may rely on it";
}

TEST_F(Handles, APerceptionSystemOfTheAppIsNotStarted) {
    script.isPerceptionStarted = true;
    EXPECT_EQ(open(head), ML2S_OK);
    EXPECT_EQ(open(depth), ML2S_OK);
    EXPECT_EQ(script.countOf("MLPerceptionStartup"), 0);
}

TEST_F(Handles, APerceptionSystemThatTheAppHasShutDownIsStartedForTheNextSensor) {
    script.isPerceptionStarted = true;
    const Sensor first(depth);
    script.isPerceptionStarted = false;
    EXPECT_EQ(open(head), ML2S_OK);
    EXPECT_EQ(script.countOf("MLPerceptionStartup"), 1);
}

TEST_F(Handles, TrackersAreCreatedAfterAFirstSnapshot) {
    script.snapshotsRefused = 3;
    EXPECT_EQ(open(head), ML2S_OK);
    const auto created = std::find(script.calls.begin(), script.calls.end(), "MLHeadTrackingCreate");
    EXPECT_EQ(std::count(script.calls.begin(), created, "MLPerceptionReleaseSnapshot"), 1);
}

TEST_F(Handles, APerceptionSystemThatCannotBeAskedIsToldAndNotStarted) {
    script.isPerceptionStarted = true;
    script.results["MLPerceptionGetSnapshot"] = MLResult_UnspecifiedFailure;
    const Sensor sensor(head);
    EXPECT_STREQ(sensor.error.message, "MLPerceptionGetSnapshot: UnspecifiedFailure (4)");
    EXPECT_EQ(script.countOf("MLPerceptionStartup"), 0);
}

TEST_F(Handles, APerceptionSystemThatDoesNotStartIsToldAndTriedAgain) {
    script.results["MLPerceptionStartup"] = MLResult_UnspecifiedFailure;
    const auto world = settingsOf(ML2S_SENSOR_WORLD, kLeft);
    const auto eye = settingsOf(ML2S_SENSOR_EYE, ML2S_STREAM_BIT(ML2S_STREAM_EYE_NASAL_LEFT));
    for (const auto &settings : {head, depth, world, eye}) {
        const Sensor sensor(settings);
        EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
        EXPECT_STREQ(sensor.error.message, "MLPerceptionStartup: UnspecifiedFailure (4)");
    }
    script.results.clear();
    EXPECT_EQ(open(head), ML2S_OK);
}

TEST_F(Handles, APerceptionSystemWhoseStartDoesNotReturnIsToldToOtherSensors) {
    {
        const Stuck stuck("MLPerceptionStartup", [&] { EXPECT_EQ(open(head), ML2S_OK); });
        const Sensor other(depth);
        EXPECT_EQ(other.result, ML2S_VENDOR_FAILURE);
        EXPECT_STREQ(other.error.message, "MLPerceptionStartup has not returned to another sensor");
    }
    EXPECT_EQ(open(depth), ML2S_OK);
}

TEST_F(Handles, ASnapshotThatIsNotReleasedTakesNoPoseFromOtherSensors) {
    for (const auto *function : {"MLPerceptionGetPredictedSnapshot", "MLSnapshotGetTransform"}) {
        const Stuck stuck(function, [&] {
            Sensor sensor(head);
            EXPECT_TRUE(sensor.pollReading().is_tracked);
        });
        Sensor color(settingsOf(ML2S_SENSOR_COLOR, ML2S_STREAM_BIT(ML2S_STREAM_COLOR)));
        EXPECT_EQ(color.result, ML2S_OK) << color.error.message;
        EXPECT_TRUE(color.colorPose(scripted::kOffsetNanos).is_tracked) << color.error.message;
    }
}

TEST_F(Handles, ADisconnectThatFailsIsToldAndTheSensorIsClosedAllTheSame) {
    script.results["MLDepthCameraDisconnect"] = MLResult_UnspecifiedFailure;
    Sensor sensor(depth);
    EXPECT_EQ(sensor.close(), ML2S_VENDOR_FAILURE);
    EXPECT_STREQ(sensor.error.message, "MLDepthCameraDisconnect: UnspecifiedFailure (4)");
    script.results.clear();
    EXPECT_EQ(open(depth), ML2S_OK);
}

TEST_F(Handles, LeasedSlotsStayValidWhenTheirSensorIsClosed) {
    std::vector<uint8_t> pixels(16, 7);
    MLWorldCameraFrame frame = {};
    frame.id = MLWorldCameraIdentifier_Left;
    frame.frame_type = MLWorldCameraFrameType_NormalExposure;
    frame.frame_buffer = {4, 4, 4, 1, 16, pixels.data()};
    script.worldFrames = {frame};
    const Slots slots(ML2S_STREAM_WORLD_LEFT);
    Sensor sensor(settingsOf(ML2S_SENSOR_WORLD, kLeft));
    const Only got(sensor.poll());
    EXPECT_EQ(sensor.close(), ML2S_OK);
    EXPECT_EQ(got.data[15], 7);
}
