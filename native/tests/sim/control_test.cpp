// Keys, time and what ml2sim.h says of the truth.
#include <atomic>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include <unistd.h>

#include "headset.h"
#include "ml_time.h"

class Control : public SimulatedHeadset {};

TEST_F(Control, AnUnknownKeyIsAnsweredWithTheNearest) {
    EXPECT_STREQ(ml2sim_set("fault.word.staled", "1"),
                 "unknown key \"fault.word.staled\"; the nearest is \"fault.world.stalled\"");
}

TEST_F(Control, AWrongValueIsAnsweredWithWhatIsAllowedAndChangesNothing) {
    EXPECT_STREQ(ml2sim_set("loop_seconds", "1"), "loop_seconds: expected a whole number from 2 to 600, found \"1\"");
    EXPECT_STREQ(ml2sim_set("loop_seconds", "2.5"),
                 "loop_seconds: expected a whole number from 2 to 600, found \"2.5\"");
    EXPECT_STREQ(ml2sim_set("clock", "fast"), "clock: expected one of \"real\", \"manual\", found \"fast\"");
    EXPECT_NE(std::string(ml2sim_describe_keys()).find("loop_seconds\t2\t"), std::string::npos);
    EXPECT_NE(std::string(ml2sim_describe_keys()).find("clock\tmanual\t"), std::string::npos);
}

TEST_F(Control, ATrajectoryThatCannotBeReadIsToldAndTheOldOneStays) {
    ml2sim_pose before, after;
    ml2sim_true_head(1 * kSecond, &before);
    EXPECT_NE(ml2sim_set("trajectory", "/does/not/exist.tum"), nullptr);
    ml2sim_true_head(1 * kSecond, &after);
    EXPECT_EQ(std::memcmp(&before, &after, sizeof before), 0);
}

TEST_F(Control, EveryKeyIsDescribedAndCanBeSetToItsOwnValue) {
    const std::string all = ml2sim_describe_keys();
    int keys = 0;
    for (size_t at = 0; at < all.size(); at = all.find('\n', at) + 1, keys++) {
        const auto name = all.find('\t', at), value = all.find('\t', name + 1);
        EXPECT_EQ(ml2sim_set(all.substr(at, name - at).c_str(), all.substr(name + 1, value - name - 1).c_str()),
                  nullptr);
    }
    EXPECT_GT(keys, 60);
}

TEST_F(Control, TheEnvironmentIsReadAtTheStart) {
    setenv("ML2SIM", "seed=42,fault.eye.permission=1", 1);
    ml2sim_reset();
    unsetenv("ML2SIM");
    EXPECT_NE(std::string(ml2sim_describe_keys()).find("seed\t42\t"), std::string::npos);
    EXPECT_NE(std::string(ml2sim_describe_keys()).find("fault.eye.permission\t1\t"), std::string::npos);
}

TEST_F(Control, TheManualClockStandsUntilItIsAdvanced) {
    const auto before = ml2sim_now_mltime();
    EXPECT_EQ(ml2sim_now_mltime(), before);
    ml2sim_advance(12345);
    EXPECT_EQ(ml2sim_now_mltime(), before + 12345);
}

TEST_F(Control, MlTimeIsFarFromEveryOtherClockAndConvertsBothWays) {
    set("mltime_skew_ppm", "40");
    const timespec monotonic = {5000, 123456789};
    MLTime time = 0;
    ASSERT_EQ(MLTimeConvertSystemTimeToMLTime(&monotonic, &time), MLResult_Ok);
    EXPECT_GT(time - 5000 * kSecond, 1000000 * kSecond);
    timespec back{};
    ASSERT_EQ(MLTimeConvertMLTimeToSystemTime(time, &back), MLResult_Ok);
    EXPECT_EQ(back.tv_sec, 5000);
    EXPECT_NEAR(double(back.tv_nsec), 123456789, 1);
}

TEST_F(Control, SkewIsPartsPerMillionOfTheSystemsTime) {
    set("mltime_skew_ppm", "40");
    const timespec first = {5000, 0}, second = {6000, 0};
    MLTime a = 0, b = 0;
    MLTimeConvertSystemTimeToMLTime(&first, &a);
    MLTimeConvertSystemTimeToMLTime(&second, &b);
    EXPECT_EQ(b - a, 1000 * kSecond + 40000000);
}

TEST_F(Control, TheRealClockIsThatOfTheSystem) {
    set("clock", "real");
    timespec before{}, after{}, converted{};
    clock_gettime(CLOCK_MONOTONIC, &before);
    MLTimeConvertMLTimeToSystemTime(ml2sim_now_mltime(), &converted);
    clock_gettime(CLOCK_MONOTONIC, &after);
    const auto nanos = [](const timespec &t) { return t.tv_sec * kSecond + t.tv_nsec; };
    EXPECT_GE(nanos(converted), nanos(before) - 1);
    EXPECT_LE(nanos(converted), nanos(after));
}

TEST_F(Control, ConversionsRefuseWhatIsNoTimeAndFailByFault) {
    const timespec wrong = {1, 1000000000};
    MLTime time = 0;
    timespec system{};
    EXPECT_EQ(MLTimeConvertSystemTimeToMLTime(&wrong, &time), MLResult_InvalidParam);
    EXPECT_EQ(MLTimeConvertMLTimeToSystemTime(0, &system), MLResult_InvalidParam);
    expectMisuse(ML2SIM_MISUSE_ARGUMENT, 2);
    set("fault.time.convert", "1");
    EXPECT_EQ(MLTimeConvertMLTimeToSystemTime(ml2sim_now_mltime(), &system), MLResult_UnspecifiedFailure);
}

TEST_F(Control, AFunctionThatIsHeldReturnsWhenItIsHeldNoLongerAndOthersReturnMeanwhile) {
    set("held", "MLHeadTrackingCreate+MLTimeConvertMLTimeToSystemTime");
    std::atomic<bool> hasReturned{false};
    std::thread caller([&hasReturned] {
        timespec system{};
        EXPECT_EQ(MLTimeConvertMLTimeToSystemTime(ml2sim_now_mltime(), &system), MLResult_Ok);
        hasReturned = true;
    });
    const timespec now = {1000, 0};
    for (int calls = 0; calls < 1000; calls++) {
        MLTime time = 0;
        EXPECT_EQ(MLTimeConvertSystemTimeToMLTime(&now, &time), MLResult_Ok);
        usleep(100);
    }
    EXPECT_FALSE(hasReturned);
    set("held", "");
    caller.join();
}

TEST_F(Control, ThePathRepeatsAfterTheLoopAndDiffersBySeed) {
    ml2sim_pose first, again, other;
    ml2sim_true_head(500 * kMillisecond, &first);
    ml2sim_true_head(500 * kMillisecond + 2 * kSecond, &again);
    EXPECT_EQ(std::memcmp(&first, &again, sizeof first), 0);
    set("seed", "2");
    ml2sim_true_head(500 * kMillisecond, &other);
    EXPECT_NE(std::memcmp(&first, &other, sizeof first), 0);
}

class Inertial : public SimulatedHeadset {
  protected:
    /** Where a unit is in the world, by the mounts that are told and the true head. */
    void placeAt(const char *unit, int64_t mltime, double out[3]) {
        const std::string mounts = ml2sim_mounts();
        const auto entry = mounts.substr(mounts.find(unit));
        double p[3];
        ASSERT_EQ(std::sscanf(entry.c_str() + entry.find("position"), "position\": [%lf, %lf, %lf]", p, p + 1, p + 2),
                  3);
        ml2sim_pose head;
        ml2sim_true_head(mltime, &head);
        rotate(head.rotation, p, out);
        for (int i = 0; i < 3; i++)
            out[i] += head.position[i];
    }
    /** By the rotation matrix of a quaternion. */
    static void rotate(const double q[4], const double v[3], double out[3]) {
        const double x = q[0], y = q[1], z = q[2], w = q[3];
        const double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                                {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                                {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
        for (int i = 0; i < 3; i++)
            out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    }
};

TEST_F(Inertial, SpecificForceIsTheSecondDifferenceOfThePlaceAndGravity) {
    constexpr int64_t kStep = kMillisecond;
    const char *names[] = {"imu_left", "imu_right", "imu_compute_pack"};
    for (uint32_t unit = 0; unit < ML2SIM_UNIT_COUNT; unit++) {
        const auto boottime = ml2sim_now_boottime() + 300 * kMillisecond;
        const auto time = ml2sim_mltime_of_boottime(boottime);
        double before[3], now[3], after[3], squares = 0;
        placeAt(names[unit], time - kStep, before);
        placeAt(names[unit], time, now);
        placeAt(names[unit], time + kStep, after);
        for (int i = 0; i < 3; i++) {
            const double acceleration = (after[i] - 2 * now[i] + before[i]) * 1e6 + (i == 1 ? 9.80665 : 0);
            squares += acceleration * acceleration;
        }
        float accel[3];
        ASSERT_EQ(ml2sim_imu(unit, boottime, accel, nullptr, nullptr), 0);
        EXPECT_NEAR(std::hypot(accel[0], accel[1], accel[2]), std::sqrt(squares), 2e-3) << names[unit];
    }
}

TEST_F(Inertial, AngularVelocityIsAsFastAsTheHeadTurns) {
    const auto boottime = ml2sim_now_boottime();
    const auto time = ml2sim_mltime_of_boottime(boottime);
    ml2sim_pose before, after;
    ml2sim_true_head(time - 500000, &before);
    ml2sim_true_head(time + 500000, &after);
    double same = 0;
    for (int i = 0; i < 4; i++)
        same += before.rotation[i] * after.rotation[i];
    const double rate = 2 * std::sqrt(std::max(0.0, 1 - same * same)) / 1e-3;
    float gyro[3];
    ml2sim_imu(ML2SIM_COMPUTE_PACK, boottime, nullptr, gyro, nullptr);
    EXPECT_NEAR(std::hypot(gyro[0], gyro[1], gyro[2]), rate, 1e-3);
}

TEST_F(Inertial, BiasAndNoiseAreEqualAtEqualTimesAndNoiseHasItsDeviation) {
    const auto boottime = ml2sim_now_boottime();
    float exact[3], first[3], again[3];
    ml2sim_imu(0, boottime, exact, nullptr, nullptr);
    set("imu_noise", "1");
    ml2sim_imu(0, boottime, first, nullptr, nullptr);
    ml2sim_imu(0, boottime, again, nullptr, nullptr);
    EXPECT_EQ(std::memcmp(first, again, sizeof first), 0);
    double squares = 0;
    for (int i = 0; i < 3000; i++) {
        float clean[3], noisy[3];
        set("imu_noise", "0");
        ml2sim_imu(0, boottime + i, clean, nullptr, nullptr);
        set("imu_noise", "1");
        ml2sim_imu(0, boottime + i, noisy, nullptr, nullptr);
        squares += std::pow(noisy[0] - clean[0], 2);
    }
    EXPECT_NEAR(std::sqrt(squares / 3000), 0.02, 0.002);
    set("imu_noise", "0");
    set("imu_bias", "1");
    ml2sim_imu(0, boottime, first, nullptr, nullptr);
    EXPECT_NE(first[0], exact[0]);
    EXPECT_NEAR(first[0], exact[0], 0.05);
}

TEST_F(Inertial, LightAndPressureArePlausibleAndUnknownUnitsAreRefused) {
    EXPECT_NEAR(ml2sim_light(ml2sim_now_boottime()), 300, 151);
    const float head = ml2sim_pressure(ML2SIM_HEADSET_LEFT, ml2sim_now_boottime());
    const float pack = ml2sim_pressure(ML2SIM_COMPUTE_PACK, ml2sim_now_boottime());
    EXPECT_NEAR(head, 101325, 50);
    EXPECT_GT(pack, head) << "the pack hangs lower";
    float accel[3];
    EXPECT_EQ(ml2sim_imu(3, 0, accel, nullptr, nullptr), -1);
    EXPECT_EQ(ml2sim_pressure(3, 0), -1);
    ml2sim_pose pose;
    EXPECT_EQ(ml2sim_true_pose(ML2SIM_CAMERA_COUNT, 0, &pose), -1);
}

TEST_F(Control, LandmarksAreInTheRoomAndWallsBoundThem) {
    const std::string text = ml2sim_landmarks();
    EXPECT_NE(text.find("\"tags\": [{\"id\": "), std::string::npos);
    size_t walls = 0;
    for (size_t at = 0; (at = text.find("\"offset_m\"", at)) != std::string::npos; at++)
        walls++;
    EXPECT_EQ(walls, 6u);
}

class TumPath : public SimulatedHeadset {};

TEST_F(TumPath, TheHeadRestsUntilACameraShowsItAndAfterItsEnd) {
    const auto path = testing::TempDir() + "ml2sim_path_" + std::to_string(getpid()) + ".tum";
    std::ofstream(path) << "# timestamp tx ty tz qx qy qz qw\n10 0 0 0 0 0 0 1\n11 0.5 0 0 0 0 0 1\n12 1 0 0 0 0 0 1\n";
    set("trajectory", path.c_str());
    ml2sim_pose head;
    ml2sim_true_head(ml2sim_now_mltime() + 100 * kSecond, &head);
    EXPECT_NEAR(head.position[2], 0, 1e-9);
    const ml2sim_color_request request = {640, 480, 30, 0};
    ml2sim_color_frame frame;
    ASSERT_EQ(ml2sim_color(&request, ml2sim_now_boottime(), &frame), 0);
    ml2sim_true_head(ml2sim_now_mltime() + 100 * kSecond, &head);
    EXPECT_NEAR(head.position[2], -1, 1e-9) << "ROS forward is the device's -z";
    set("trajectory", "");
}
