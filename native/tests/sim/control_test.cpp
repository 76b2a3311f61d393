// Keys, time and what ml2sim.h says of the truth.
#include <algorithm>
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
    static constexpr const char *kNames[] = {"imu_left", "imu_right", "imu_compute_pack"};

    struct Mount {
        double rotation[4], position[3];
    };
    static Mount mountOf(uint32_t unit) {
        const std::string mounts = ml2sim_mounts();
        const auto entry = mounts.substr(mounts.find(kNames[unit]));
        Mount m = {};
        double *q = m.rotation, *p = m.position;
        EXPECT_EQ(std::sscanf(entry.c_str() + entry.find("rotation"),
                              "rotation\": [%lf, %lf, %lf, %lf], \"position\": [%lf, %lf, %lf]", q, q + 1, q + 2, q + 3,
                              p, p + 1, p + 2),
                  7);
        return m;
    }
    /** Places a unit in the world, by the mounts that are told and the true head. */
    static void placeAt(uint32_t unit, int64_t mltime, double out[3]) {
        ml2sim_pose head;
        ml2sim_true_head(mltime, &head);
        rotate(head.rotation, mountOf(unit).position, out);
        for (int i = 0; i < 3; i++)
            out[i] += head.position[i];
    }
    /** Turns what a unit measures to the axes of the world. */
    static void turnAt(uint32_t unit, int64_t mltime, const float measured[3], double out[3]) {
        ml2sim_pose head;
        ml2sim_true_head(mltime, &head);
        const double ofUnit[] = {measured[0], measured[1], measured[2]};
        double ofHead[3];
        rotate(mountOf(unit).rotation, ofUnit, ofHead);
        rotate(head.rotation, ofHead, out);
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
    for (uint32_t unit = 0; unit < ML2SIM_UNIT_COUNT; unit++) {
        const auto boottime = ml2sim_now_boottime() + 300 * kMillisecond;
        const auto time = ml2sim_mltime_of_boottime(boottime);
        double before[3], now[3], after[3], force[3];
        placeAt(unit, time - kStep, before);
        placeAt(unit, time, now);
        placeAt(unit, time + kStep, after);
        float accel[3];
        ASSERT_EQ(ml2sim_imu(unit, boottime, accel, nullptr, nullptr), 0);
        turnAt(unit, time, accel, force);
        for (int i = 0; i < 3; i++)
            EXPECT_NEAR(force[i], (after[i] - 2 * now[i] + before[i]) * 1e6 + (i == 1 ? 9.80665 : 0), 2e-3)
                << kNames[unit];
    }
}

TEST_F(Inertial, AngularVelocityIsTheTurnOfTheHead) {
    const auto boottime = ml2sim_now_boottime();
    const auto time = ml2sim_mltime_of_boottime(boottime);
    ml2sim_pose before, after;
    ml2sim_true_head(time - 500000, &before);
    ml2sim_true_head(time + 500000, &after);
    const auto &a = after.rotation, &b = before.rotation;
    // The vector of after * conjugate(before), which is half the turn within a millisecond
    const double half[] = {a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
                           a[1] * b[3] - a[3] * b[1] - a[2] * b[0] + a[0] * b[2],
                           a[2] * b[3] - a[3] * b[2] - a[0] * b[1] + a[1] * b[0]};
    for (uint32_t unit = 0; unit < ML2SIM_UNIT_COUNT; unit++) {
        float gyro[3];
        double turn[3];
        ASSERT_EQ(ml2sim_imu(unit, boottime, nullptr, gyro, nullptr), 0);
        turnAt(unit, time, gyro, turn);
        for (int i = 0; i < 3; i++)
            EXPECT_NEAR(turn[i], 2 * half[i] / 1e-3, 1e-3) << kNames[unit];
    }
}

TEST_F(Inertial, TheMagneticFieldIsFixedInTheWorld) {
    double fields[2 * ML2SIM_UNIT_COUNT][3];
    for (uint32_t i = 0; i < 2 * ML2SIM_UNIT_COUNT; i++) {
        const auto boottime = ml2sim_now_boottime() + i * 300 * kMillisecond;
        float mag[3];
        ASSERT_EQ(ml2sim_imu(i / 2, boottime, nullptr, nullptr, mag), 0);
        turnAt(i / 2, ml2sim_mltime_of_boottime(boottime), mag, fields[i]);
        for (int axis = 0; axis < 3; axis++)
            EXPECT_NEAR(fields[i][axis], fields[0][axis], 1e-10) << i;
    }
    EXPECT_NEAR(fields[0][1], -42e-6, 1e-10);
    EXPECT_NEAR(std::hypot(fields[0][0], fields[0][2]), 22e-6, 1e-10);
}

TEST_F(Inertial, WithoutNoiseTheBytesAreThoseOfAHeadsetThatHadNone) {
    uint64_t hash = 0xcbf29ce484222325; // FNV-1a
    for (uint32_t unit = 0; unit < ML2SIM_UNIT_COUNT; unit++)
        for (int64_t i = 0; i < 100; i++) {
            const auto boottime = ml2sim_boottime_of_mltime(8000000 * kSecond + i * 17 * kMillisecond);
            float values[9];
            ASSERT_EQ(ml2sim_imu(unit, boottime, values, values + 3, values + 6), 0);
            unsigned char bytes[sizeof values];
            std::memcpy(bytes, values, sizeof bytes);
            for (const auto byte : bytes)
                hash = (hash ^ byte) * 0x100000001b3;
        }
    EXPECT_EQ(hash, 0xb7c4a12b535a3348);
}

TEST_F(Inertial, EqualTimesHaveEqualNoiseAndABiasIsBounded) {
    const auto boottime = ml2sim_now_boottime();
    float exact[3], first[3], again[3];
    ml2sim_imu(0, boottime, exact, nullptr, nullptr);
    set("noise", "1");
    ml2sim_imu(0, boottime, first, nullptr, nullptr);
    ml2sim_imu(0, boottime, again, nullptr, nullptr);
    EXPECT_EQ(std::memcmp(first, again, sizeof first), 0);
    EXPECT_NE(std::memcmp(first, exact, sizeof first), 0);
    set("noise", "0");
    set("imu_bias", "1");
    ml2sim_imu(0, boottime, first, nullptr, nullptr);
    EXPECT_NE(first[0], exact[0]);
    EXPECT_NEAR(first[0], exact[0], 0.05);
}

TEST_F(Inertial, OnlyTheComputePackSwingsWithNoiseAndItsForceIsThatOfItsTurns) {
    const auto swings = [](uint32_t unit) {
        // The head is at rest. The walk and the white noise are a hundredth of the swing when summed over seconds.
        const auto start = ml2sim_boottime_of_mltime(8000000 * kSecond);
        constexpr int kSamples = 2000;
        double turn = 0, force = 0;
        for (int i = 0; i < kSamples; i++) {
            float accel[3], gyro[3];
            ml2sim_imu(unit, start + i * 5 * kMillisecond, accel, gyro, nullptr);
            const double phase = 4 * M_PI * i * 5e-3;
            // The pack looks to the left: the head's right is its back, z; the head's front is its right, x.
            turn += std::cos(phase) * gyro[2] * 2 / kSamples;
            force += std::sin(phase) * accel[0] * 2 / kSamples;
        }
        return std::pair(turn, force);
    };
    set("trajectory", STILL_HEAD);
    set("noise", "1");
    const auto [turn, force] = swings(ML2SIM_COMPUTE_PACK);
    const double amplitude = 0.025, speed = 4 * M_PI;
    EXPECT_NEAR(std::abs(turn), amplitude * speed, 0.02 * amplitude * speed);
    // A pendulum of 0.1 m: gravity, less what its own acceleration takes.
    const double expected = amplitude * (9.80665 - 0.1 * speed * speed);
    EXPECT_NEAR(std::abs(force), std::abs(expected), 0.05 * std::abs(expected));
    EXPECT_NEAR(swings(ML2SIM_HEADSET_LEFT).first, 0, 2e-3);
    set("trajectory", "");
}

TEST_F(Inertial, MountsAreDrawnByTheirKeyAndStampsAreThenLate) {
    const std::string built = ml2sim_mounts();
    EXPECT_NE(built.find("\"late_s\": 0.000000000}"), std::string::npos);
    set("mounts", "1");
    const std::string drawn = ml2sim_mounts();
    EXPECT_NE(drawn.substr(drawn.find("imu_left")), built.substr(built.find("imu_left")));
    EXPECT_EQ(drawn.substr(0, drawn.find("imu_left")), built.substr(0, built.find("imu_left"))) << "cameras";
    EXPECT_EQ(drawn.substr(drawn.find("imu_compute")), built.substr(built.find("imu_compute"))) << "not on the head";
    // The turn rate has the same length for every mount, so it shows how late the stamps are.
    double late_s = 0;
    const auto entry = drawn.substr(drawn.find("late_s"));
    ASSERT_EQ(std::sscanf(entry.c_str(), "late_s\": %lf", &late_s), 1);
    EXPECT_NE(late_s, 0);
    EXPECT_LE(std::abs(late_s), 0.02);
    const auto turn = [](int64_t boottime) {
        float gyro[3];
        ml2sim_imu(ML2SIM_HEADSET_LEFT, boottime, nullptr, gyro, nullptr);
        return std::hypot(gyro[0], gyro[1], gyro[2]);
    };
    const auto boottime = ml2sim_now_boottime();
    const double lateTurn = turn(boottime + std::llround(late_s * 1e9));
    set("mounts", "0");
    EXPECT_NEAR(lateTurn, turn(boottime), 1e-6);
    EXPECT_GT(std::abs(lateTurn - turn(boottime + std::llround(late_s * 1e9))), 1e-4);
}

TEST_F(Control, NoiseIsInTheReportedHeadAndNotInTheTrueOne) {
    ml2sim_pose truth, found, again;
    const auto at = [](int64_t i) { return 8000000 * kSecond + i * 151 * kMillisecond; };
    ml2sim_true_head(at(0), &truth);
    ml2sim_reported_head(at(0), &found);
    EXPECT_EQ(std::memcmp(&truth, &found, sizeof truth), 0);
    set("noise", "1");
    ml2sim_true_head(at(0), &again);
    EXPECT_EQ(std::memcmp(&truth, &again, sizeof truth), 0);
    ml2sim_reported_head(at(0), &found);
    ml2sim_reported_head(at(0), &again);
    EXPECT_EQ(std::memcmp(&found, &again, sizeof found), 0) << "equal times, equal poses";
    // The drift is straight for a second: second differences have six times the variance of the jitter.
    double squares = 0, angles = 0, farthest = 0, errors[3][3] = {};
    constexpr int kPoses = 3000;
    for (int i = 0; i < kPoses; i++) {
        ml2sim_true_head(at(i), &truth);
        ml2sim_reported_head(at(i), &found);
        const auto &a = truth.rotation, &b = found.rotation;
        const double same = std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]);
        angles += std::pow(2 * std::acos(std::min(1.0, same)), 2) / kPoses;
        for (int k = 0; k < 3; k++) {
            auto &[before, now, after] = errors[k];
            before = now, now = after, after = found.position[k] - truth.position[k];
            squares += i < 2 ? 0 : std::pow(before - 2 * now + after, 2) / 6 / (3 * kPoses);
            farthest = std::max(farthest, std::abs(after));
        }
    }
    EXPECT_NEAR(std::sqrt(squares), 0.5e-3, 0.05 * 0.5e-3);
    EXPECT_GT(farthest, 5e-3) << "it drifts";
    EXPECT_LT(farthest, 0.1) << "and its map bounds that";
    EXPECT_NEAR(std::sqrt(angles) * 180 / M_PI, 0.11, 0.03) << "0.05 about each axis, and the heading's drift";
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
