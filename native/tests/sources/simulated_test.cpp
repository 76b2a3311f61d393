// The sources with the simulated headset: the result of each of its faults, and no leak and no misuse.
#include <optional>

#include "../sim/headset.h"
#include "ml_perception.h"
#include "sensor.h"

namespace {

uint64_t bits(std::initializer_list<ml2s_stream> streams) {
    uint64_t mask = 0;
    for (const auto stream : streams) {
        mask |= ML2S_STREAM_BIT(stream);
    }
    return mask;
}

/** A headset whose clock the test advances. The end of each test checks for leaks and misuses. */
class Simulated : public testing::Test {
  protected:
    void SetUp() override {
        ml2sim_reset();
        set("clock", "manual");
        set("loop_seconds", "2");
        set("mltime_skew_ppm", "200");
        set("noise", "0"); // tests compare with the truth
        ml2sim_advance(kSecond);
    }
    void TearDown() override {
        const auto left = counters();
        EXPECT_STREQ(left.last_misuse, "");
        EXPECT_EQ(left.open_handles + left.outstanding_gets + left.outstanding_snapshots, 0u);
    }

    const ml2s_settings color = settingsOf(ML2S_SENSOR_COLOR, bits({ML2S_STREAM_COLOR}));
};

struct Camera {
    const char *name;
    ml2s_sensor sensor;
    ml2s_stream stream;
    uint32_t image_bytes;
    bool hasPose;
};

/** For messages of failing tests. */
void PrintTo(const Camera &camera, std::ostream *out) { *out << camera.name; }

class SimulatedCamera : public Simulated, public testing::WithParamInterface<Camera> {
  protected:
    void SetUp() override {
        Simulated::SetUp();
        slots_.emplace(GetParam().stream);
    }
    void TearDown() override {
        slots_.reset();
        Simulated::TearDown();
    }
    ml2s_settings settings() const { return settingsOf(GetParam().sensor, bits({GetParam().stream})); }
    void setFault(const char *what, const char *value) {
        set(std::string("fault.") + GetParam().name + "." + what, value);
    }
    /** Returns the result of the next frame. */
    Polled capture(Sensor &sensor) {
        ml2sim_advance(kSecond);
        return sensor.poll();
    }

  private:
    std::optional<Slots> slots_;
};

void expectNear(const float *found, const double *truth, int count) {
    for (int i = 0; i < count; i++) {
        EXPECT_NEAR(found[i], truth[i], 1e-5);
    }
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Each, SimulatedCamera,
                         testing::Values(Camera{"depth", ML2S_SENSOR_DEPTH, ML2S_STREAM_DEPTH, 544 * 480 * 4, true},
                                         Camera{"world", ML2S_SENSOR_WORLD, ML2S_STREAM_WORLD_LEFT, 1016 * 1016, true},
                                         Camera{"eye", ML2S_SENSOR_EYE, ML2S_STREAM_EYE_NASAL_LEFT, 400 * 400, false}),
                         [](const auto &info) { return info.param.name; });

TEST_P(SimulatedCamera, AFrameHasTheTrueTimeAndPose) {
    Sensor sensor(settings());
    const Only got(capture(sensor));
    EXPECT_EQ(got.planes[0].size_bytes, GetParam().image_bytes);
    EXPECT_NEAR(static_cast<double>(got.capture_nanos - ml2sim_boottime_of_mltime(got.device_nanos)), 0, 1e6);
    EXPECT_EQ((got.has & ML2S_HAS_POSE) != 0, GetParam().hasPose);
    ml2sim_pose truth;
    const uint32_t camera = GetParam().sensor == ML2S_SENSOR_DEPTH ? ML2SIM_DEPTH : ML2SIM_WORLD_LEFT;
    ASSERT_EQ(ml2sim_true_pose(camera, got.device_nanos, &truth), 0);
    if (GetParam().hasPose) {
        expectNear(got.rotation, truth.rotation, 4);
        expectNear(got.position, truth.position, 3);
    }
}

TEST_P(SimulatedCamera, ACameraThatWentAwayIsToldAndComesBackWhenItIsOpenedAgain) {
    {
        Sensor sensor(settings());
        setFault("disconnected", "1");
        EXPECT_TRUE(capture(sensor).empty());
        EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
        EXPECT_NE(std::string(sensor.error.message).find("Data: UnspecifiedFailure (4)"), std::string::npos);
        setFault("disconnected", "0");
    }
    Sensor sensor(settings());
    const auto frames = capture(sensor);
    EXPECT_EQ(frames.size(), 1u);
}

TEST_P(SimulatedCamera, WhatCannotBeOpenedSaysWhy) {
    struct {
        const char *fault;
        ml2s_result result;
        const char *message;
    } const rows[] = {
        {"permission", ML2S_PERMISSION_DENIED, "Connect: PermissionDenied (7)"},
        {"connect", ML2S_VENDOR_FAILURE, "Connect: UnspecifiedFailure (4)"},
    };
    for (const auto &row : rows) {
        setFault(row.fault, "1");
        const Sensor sensor(settings());
        EXPECT_EQ(sensor.result, row.result);
        EXPECT_NE(std::string(sensor.error.message).find(row.message), std::string::npos) << sensor.error.message;
        setFault(row.fault, "0");
        EXPECT_EQ(Sensor(settings()).result, ML2S_OK) << "and afterwards it opens";
    }
}

TEST_P(SimulatedCamera, AFailureOfARunningCameraIsTold) {
    struct {
        const char *fault;
        const char *value;
        const char *standard;
        const char *message; ///< Null when the poll just times out.
    } const rows[] = {
        {"stalled", "1", "0", nullptr},
        {"frame_count", "0", "-1", nullptr},
        {"get", "1", "0", "Data: UnspecifiedFailure (4)"},
        {"get", "2", "0", "Data: MLResult 0xffffffe0"},
    };
    Sensor sensor(settings());
    for (const auto &row : rows) {
        setFault(row.fault, row.value);
        EXPECT_TRUE(capture(sensor).empty()) << row.fault;
        EXPECT_EQ(sensor.result, row.message ? ML2S_VENDOR_FAILURE : ML2S_TIMEOUT) << row.fault;
        const std::string message = sensor.error.message;
        EXPECT_TRUE(!row.message || message.find(row.message) != std::string::npos) << row.fault << ": " << message;
        setFault(row.fault, row.standard);
    }
    const auto frames = capture(sensor);
    EXPECT_EQ(frames.size(), 1u) << "and afterwards frames come as before";
}

TEST_P(SimulatedCamera, EveryMalformedStructureIsSkippedAndARunOfThemFailsThePoll) {
    struct {
        const char *fault;
        const char *value;
        const char *standard;
        const char *message;
    } const rows[] = {
        {"frame_count", "200", "-1", ": 200 frames at once, expected at most "},
        {"size", "10", "-1", " do not fit 10 bytes"},
        {"stride", "4", "-1", " with stride 4 do not fit "},
        {"width", "4294967295", "-1", ": 4294967295x"},
        {"width", "0", "-1", ": empty picture of 0x"},
        {"bytes_per_pixel", "3", "-1", ": 3 bytes per pixel, expected "},
        {"null_data", "1", "0", ": empty picture of "},
        {"null_frames", "1", "0", ": 1 frames, but the pointer to them is null"},
        {"id", "1", "0", "64"},
    };
    Sensor sensor(settings());
    for (const auto &row : rows) {
        setFault(row.fault, row.value);
        expectOdd(sensor, row.message, [&] { return capture(sensor); });
        setFault(row.fault, row.standard);
        const Only got(capture(sensor));
        EXPECT_EQ(got.skipped, 0u);
    }
}

TEST_P(SimulatedCamera, OddFramesAreSkippedAndCounted) {
    set("trajectory", STILL_HEAD);
    setFault("odd_every", "3");
    Sensor sensor(settings());
    uint32_t usable = 0, skipped = 0;
    for (int polls = 0; usable < 40; polls++) {
        ASSERT_LT(polls, 400) << usable << " usable frames";
        ml2sim_advance(kSecond / 30);
        for (const auto &frame : sensor.poll()) {
            usable += frame.slot != ML2S_NO_SLOT;
            skipped += frame.skipped;
        }
        ASSERT_TRUE(sensor.result == ML2S_OK || sensor.result == ML2S_TIMEOUT) << sensor.error.message;
    }
    EXPECT_GE(skipped, 10u);
    EXPECT_LE(skipped, usable);
}

TEST_P(SimulatedCamera, AChangedVersionIsNotCarriedIntoTheNextPoll) {
    setFault("version", "1");
    Sensor sensor(settings());
    for (int i = 0; i < 2; i++) {
        const auto frames = capture(sensor);
        EXPECT_EQ(frames.size(), 1u) << sensor.error.message;
    }
}

TEST_P(SimulatedCamera, APoseThatIsNoNumberIsNone) {
    setFault("not_finite", "1");
    Sensor sensor(settings());
    if (GetParam().sensor == ML2S_SENSOR_DEPTH) {
        expectOdd(sensor, "depth: intrinsics are not finite, so z is unknown; the option radial works without",
                  [&] { return capture(sensor); });
    } else {
        const Only got(capture(sensor));
        EXPECT_EQ(got.has, 0u);
    }
}

TEST_P(SimulatedCamera, AnUnusablePoseCostsThePoseOnly) {
    Sensor sensor(settings());
    for (const auto *kind : {"1", "2", "3"}) {
        set("fault.pose.unusable", kind);
        const Only got(capture(sensor));
        EXPECT_EQ(got.has & ML2S_HAS_POSE, 0u);
    }
}

TEST_P(SimulatedCamera, WhatTheTimeCannotBeToldOfIsNotDelivered) {
    Sensor sensor(settings());
    set("fault.time.convert", "1");
    expectOdd(sensor, "MLTimeConvertMLTimeToSystemTime: UnspecifiedFailure (4)", [&] { return capture(sensor); });
}

TEST_F(Simulated, TheDepthCameraTellsTheRatesThatItHasHere) {
    const auto depth = bits({ML2S_STREAM_DEPTH});
    const auto ratesOf = [](const Sensor &sensor) {
        std::vector<uint32_t> rates(8);
        uint32_t count = 0;
        EXPECT_EQ(ml2s_list_rates(sensor.handle(), rates.data(), 8, &count, nullptr), ML2S_OK);
        rates.resize(count);
        return rates;
    };
    Sensor shortRange(settingsOf(ML2S_SENSOR_DEPTH, depth, depth));
    EXPECT_EQ(ratesOf(shortRange), (std::vector<uint32_t>{5, 25, 30, 50, 60}));
    set("mains_hz", "50");
    EXPECT_EQ(ratesOf(shortRange), (std::vector<uint32_t>{5, 25, 50}));
    set("mains_hz", "60");
    EXPECT_EQ(ratesOf(shortRange), (std::vector<uint32_t>{5, 30, 60}));
    EXPECT_EQ(shortRange.close(), ML2S_OK);
    EXPECT_EQ(ratesOf(Sensor(settingsOf(ML2S_SENSOR_DEPTH, depth))), (std::vector<uint32_t>{1, 5}));
    uint32_t rate, count;
    const Sensor head(settingsOf(ML2S_SENSOR_HEAD, bits({ML2S_STREAM_HEAD_POSE})));
    EXPECT_EQ(ml2s_list_rates(head.handle(), &rate, 1, &count, nullptr), ML2S_INVALID_ARGUMENT);
}

TEST_F(Simulated, TheColourCameraIsWhereItTrulyWasAtTheTimeAsked) {
    Sensor sensor(color);
    ml2sim_advance(kSecond);
    const int64_t asked = ml2sim_now_mltime() - kSecond / 50;
    const auto pose = sensor.colorPose(asked);
    ASSERT_EQ(sensor.result, ML2S_OK) << sensor.error.message;
    ml2sim_pose truth;
    ASSERT_EQ(ml2sim_true_pose(ML2SIM_COLOR, asked, &truth), 0);
    expectNear(pose.rotation, truth.rotation, 4);
    expectNear(pose.position, truth.position, 3);
}

TEST_F(Simulated, DepthEyesAndColourRunBesideEachOther) {
    const Slots depthSlots(ML2S_STREAM_INFRA), eyeSlots(ML2S_STREAM_EYE_TEMPLE_LEFT);
    Sensor depth(settingsOf(ML2S_SENSOR_DEPTH, bits({ML2S_STREAM_INFRA}), bits({ML2S_STREAM_INFRA})));
    Sensor eye(settingsOf(ML2S_SENSOR_EYE, bits({ML2S_STREAM_EYE_TEMPLE_LEFT})));
    Sensor colorSensor(color);
    ml2sim_advance(kSecond);
    EXPECT_EQ(depth.poll().size(), 1u) << depth.error.message;
    EXPECT_EQ(eye.poll().size(), 1u) << eye.error.message;
    colorSensor.colorPose(ml2sim_now_mltime());
    EXPECT_EQ(colorSensor.result, ML2S_OK) << colorSensor.error.message;
}
