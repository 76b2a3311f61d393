/** The path and motion of the simulated head. */
#pragma once

#include "geometry.h"

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

namespace ml2sim {

/** The head at one instant. */
struct Motion {
    Pose head;                 ///< In the world.
    Vec3 acceleration;         ///< World axes, m/s^2, without gravity.
    Vec3 angular_velocity;     ///< Head axes, rad/s.
    Vec3 angular_acceleration; ///< Head axes, rad/s^2.
};

/** A trajectory file that cannot be used; the message has the path, the line, what is expected and what was found. */
class TrajectoryError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/** A smooth motion: a pure function of time, usable from any thread. */
class Trajectory {
  public:
    /**
     * A head that walks at about 0.5 m/s and looks about, in closed form, chosen by `seed`; repeats exactly after
     * `loop_seconds` (at least 2). Its angular rate goes from slow to fast and back, by over 100 degrees per second.
     */
    static Trajectory looped(uint64_t seed, double loop_seconds);

    /**
     * The head body frame of a TUM file: lines of `timestamp tx ty tz qx qy qz qw` (seconds, metres) in a ROS world (x
     * forward, y left, z up, for the world and for the head), at least two, times rising; `#` begins a comment.
     * Between lines position and rotation are splines with continuous acceleration. Time 0 is the first line's; before
     * it and after the last line the head rests. Throws TrajectoryError, also when a position is outside the room.
     */
    static Trajectory fromTum(const std::string &path);

    Motion at(double seconds) const { return motion_(seconds); }

    /** The time after which it ends or repeats. */
    double durationSeconds() const { return duration_s_; }

  private:
    Trajectory(std::function<Motion(double)> motion, double duration_s)
        : motion_(std::move(motion)), duration_s_(duration_s) {}

    std::function<Motion(double)> motion_;
    double duration_s_;
};

} // namespace ml2sim
