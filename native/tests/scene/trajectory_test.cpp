#include "scene.h"
#include "trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include <unistd.h>

using namespace ml2sim;

namespace {

constexpr double kStep_s = 1e-5;
constexpr double kDegree = M_PI / 180;

void expectNear(Vec3 a, Vec3 b, double tolerance) { EXPECT_LT(length(a - b), tolerance); }

/** The mean angular velocity that a gyroscope would measure between two instants, in head axes. */
Vec3 numericAngularVelocity(const Trajectory &trajectory, double t) {
    const Quaternion before = trajectory.at(t - kStep_s).head.rotation,
                     after = trajectory.at(t + kStep_s).head.rotation;
    const Quaternion turn = before.conjugate() * after;
    return (2 * (turn.w < 0 ? -1 : 1) / (2 * kStep_s)) * turn.vector();
}

void expectConsistent(const Trajectory &trajectory, double t) {
    const Motion now = trajectory.at(t), before = trajectory.at(t - kStep_s), after = trajectory.at(t + kStep_s);
    expectNear(now.angular_velocity, numericAngularVelocity(trajectory, t), 1e-6);
    expectNear(now.angular_acceleration, (0.5 / kStep_s) * (after.angular_velocity - before.angular_velocity), 1e-4);
    constexpr double kLong_s = 1e-4; // Second differences need a longer step than first ones.
    const Vec3 bend =
        trajectory.at(t + kLong_s).head.position - 2.0 * now.head.position + trajectory.at(t - kLong_s).head.position;
    expectNear(now.acceleration, (1 / (kLong_s * kLong_s)) * bend, 1e-3);
}

class TumFile : public testing::Test {
  protected:
    std::string write(const std::string &text) {
        const std::string path = testing::TempDir() + "ml2scene_" + std::to_string(getpid()) + ".tum";
        std::ofstream(path) << text;
        return path;
    }

    std::string errorOf(const std::string &text) {
        try {
            Trajectory::fromTum(write(text));
        } catch (const TrajectoryError &error) {
            return error.what();
        }
        return "no error";
    }
};

} // namespace

TEST(LoopedTrajectory, DerivativesAreThoseOfThePose) {
    for (const uint64_t seed : {1u, 2u, 3u}) {
        const Trajectory trajectory = Trajectory::looped(seed, 12.5);
        for (double t = 0; t < 12.5; t += 0.37)
            expectConsistent(trajectory, t);
    }
}

TEST(LoopedTrajectory, RepeatsExactly) {
    const Trajectory trajectory = Trajectory::looped(7, 8);
    for (double t = 0; t < 8; t += 0.9) {
        const Motion a = trajectory.at(t), b = trajectory.at(t + 8);
        expectNear(a.head.position, b.head.position, 1e-12);
        expectNear(a.angular_velocity, b.angular_velocity, 1e-12);
        expectNear(a.acceleration, b.acceleration, 1e-11);
    }
}

TEST(LoopedTrajectory, TurnsSlowAndFastAndWalksSomeDecimetres) {
    for (const double loop_s : {2.0, 5.0, 10.0, 30.0}) {
        for (uint64_t seed = 0; seed < 20; seed++) {
            const Trajectory trajectory = Trajectory::looped(seed, loop_s);
            double slowest = 1e9, fastest = 0, speed = 0, left = 1e9, right = -1e9;
            for (double t = 0; t < loop_s; t += 0.01) {
                const Motion now = trajectory.at(t);
                slowest = std::min(slowest, length(now.angular_velocity));
                fastest = std::max(fastest, length(now.angular_velocity));
                speed = std::max(speed, length(trajectory.at(t + 0.001).head.position - now.head.position) / 0.001);
                left = std::min(left, now.head.position.x);
                right = std::max(right, now.head.position.x);
                EXPECT_LT(std::abs(now.head.position.z), 0.5);
            }
            EXPECT_GT(fastest - slowest, 100 * kDegree) << "seed " << seed << ", loop " << loop_s;
            EXPECT_LT(fastest, 250 * kDegree);
            EXPECT_GT(speed, 0.3);
            EXPECT_LT(speed, 1.0);
            EXPECT_GT(right - left, 0.2);
        }
    }
}

TEST(LoopedTrajectory, AShorterLoopThanTwoSecondsIsRefused) {
    EXPECT_THROW(Trajectory::looped(1, 1.5), std::invalid_argument);
}

TEST_F(TumFile, PosesAreTurnedFromRosAxes) {
    // 1 m ahead, 0.5 m left, 0.25 m up; turned 90 degrees to the left, about ROS z.
    const Trajectory trajectory = Trajectory::fromTum(write("# time tx ty tz qx qy qz qw\n"
                                                            "100 0 0 0 0 0 0 1\n"
                                                            "\n"
                                                            "102 1 0.5 0.25 0 0 0.70710678 0.70710678\n"));
    EXPECT_DOUBLE_EQ(trajectory.durationSeconds(), 2);
    const Pose end = trajectory.at(2).head;
    expectNear(end.position, {-0.5, 0.25, -1}, 1e-12);
    expectNear(rotate(end.rotation, {0, 0, -1}), {-1, 0, 0}, 1e-7);
    expectNear(trajectory.at(0).head.position, {0, 0, 0}, 1e-12);
}

TEST_F(TumFile, MotionBetweenLinesIsSmooth) {
    const Trajectory trajectory = Trajectory::fromTum(write("0.0 0.0 0.0 0.0  0 0 0 1\n"
                                                            "0.5 0.1 0.2 0.0  0.1 0 0.2 0.9747\n"
                                                            "1.1 0.3 0.1 0.1  -0.1 -0.1 -0.4 -0.9055\n"
                                                            "1.5 0.2 0.0 0.2  0 0.2 0.3 0.9327\n"
                                                            "2.0 0.0 0.1 0.1  0 0.1 0 0.995\n"));
    for (double t = 0.05; t < 2; t += 0.07)
        expectConsistent(trajectory, t);
    for (const double knot : {0.5, 1.1, 1.5}) {
        const Motion before = trajectory.at(knot - 1e-9), after = trajectory.at(knot + 1e-9);
        expectNear(before.acceleration, after.acceleration, 1e-5);
        expectNear(before.angular_acceleration, after.angular_acceleration, 1e-5);
    }
}

TEST_F(TumFile, TheHeadRestsBeforeAndAfter) {
    const Trajectory trajectory = Trajectory::fromTum(write("5 0 0 0 0 0 0 1\n6 0.5 0 0 0 0 0 1\n"));
    EXPECT_GT(length(trajectory.at(1.0).head.position), 0.49);
    expectNear(trajectory.at(7).head.position, trajectory.at(1).head.position, 1e-15);
    EXPECT_EQ(length(trajectory.at(7).angular_velocity), 0);
    EXPECT_EQ(length(trajectory.at(-1).head.position), 0);
}

TEST_F(TumFile, ErrorsNameTheLine) {
    EXPECT_NE(errorOf("0 0 0 0 0 0 0 1\n1 0 0 0 0 0\n").find(":2: expected 8 numbers"), std::string::npos);
    EXPECT_NE(errorOf("0 0 0 0 0 0 0 1 9\n").find(":1: expected 8 numbers"), std::string::npos);
    EXPECT_NE(errorOf("0 0 0 0 0 0 0 x\n").find(":1: expected 8 numbers"), std::string::npos);
    EXPECT_NE(errorOf("#\n1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n").find(":3: expected a later time"), std::string::npos);
    EXPECT_NE(errorOf("0 0 0 0 0 0 0 0.5\n").find(":1: expected a unit quaternion"), std::string::npos);
    EXPECT_NE(errorOf("0 4 0 0 0 0 0 1\n").find(":1: the position is outside"), std::string::npos);
    EXPECT_NE(errorOf("0 0 0 0 0 0 0 1\n").find("expected 2 poses or more, found 1"), std::string::npos);
    EXPECT_THROW(Trajectory::fromTum("/dev/null/nowhere/at.all"), TrajectoryError);
}
