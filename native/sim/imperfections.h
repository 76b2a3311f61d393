// The errors of the simulated headset. All are functions of time without state, chosen by the seed.
#pragma once

#include <cstdint>

#include "scene/cameras.h"

namespace ml2sim {

/** Returns a normal number with mean 0 and standard deviation 1, equal for equal keys. */
double gaussian(uint64_t key);

/** Returns a uniform number from -1 to 1, equal for equal keys. */
double symmetric(uint64_t key);

/** Returns a number for the noise of a quantity that differs by seed and by `quantity`. */
uint64_t noiseSource(uint64_t quantity);

/**
 * Returns a Wiener process in sqrt(s): its increment over t seconds has mean 0 and variance t. This holds within
 * 2^period_log2 ns; further apart, values are independent, so that it does not grow without bound.
 */
double wiener(uint64_t source, int64_t nanos, int period_log2);

/** Adds the errors of head tracking to a pose in the scene: jitter, and a drift of position and heading. */
Pose withTrackingErrors(const Pose &head, int64_t mltime);

/** An inertial unit in the head: its place, and how it moves there. Vectors have the head's axes. */
struct UnitInHead {
    Pose place;
    Vec3 velocity = {};
    Vec3 acceleration = {};
    Vec3 angular_velocity = {};
};

/** Returns an inertial unit at a time. The compute pack swings at the hip; the others are rigid. */
UnitInHead unitInHead(Imu unit, int64_t mltime);

/** Returns how an inertial unit is mounted: as built, or as the key `mounts` draws it. */
Pose mountInHead(Imu unit);

/** Returns by how much the stamps of an inertial unit are late. */
int64_t lateNanos(Imu unit);

} // namespace ml2sim
