// ml2sim_imu, ml2sim_light, ml2sim_pressure: measurements of the inertial units, light sensor and barometers.
#include <cmath>

#include "clock.h"
#include "head_path.h"
#include "ml2sim.h"
#include "scene/hash.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** Returns a uniform number in (0, 1), equal for equal keys. */
double uniform(uint64_t key) { return (static_cast<double>(mix(key) >> 11) + 0.5) * 0x1p-53; }

/** Returns a normal number with mean 0 and standard deviation 1, equal for equal keys. */
double gaussian(uint64_t key) {
    constexpr double kTau = 6.283185307179586;
    return std::sqrt(-2 * std::log(uniform(key))) * std::cos(kTau * uniform(mix(key) ^ 0x5bd1e995));
}

/** Standard gravity (CGPM 1901). */
constexpr Vec3 kGravity = {0, -9.80665, 0};
/** The magnetic field of central Europe (WMM) in tesla, with magnetic north along -z of the scene. */
constexpr Vec3 kEarthField = {0, -42e-6, -22e-6};

/** A kind of measurement, with its bias and noise for the key value 1. */
struct Quality {
    uint64_t number;
    double bias;
    double noise;
};
constexpr Quality kAccelerometer = {0, 0.05, 0.02};
constexpr Quality kGyroscope = {1, 0.005, 0.002};
constexpr Quality kMagnetometer = {2, 0, 3e-7};

bool isUnit(uint32_t unit) { return unit < ML2SIM_UNIT_COUNT; }

Pose mountOf(uint32_t unit) {
    constexpr Imu kUnits[] = {Imu::Left, Imu::Right, Imu::ComputePack};
    return mount(kUnits[unit]);
}

Vec3 specificForce(const Motion &motion, const Pose &unit) {
    const Vec3 lever = unit.position;
    const Vec3 ofHead = rotate(motion.head.rotation.conjugate(), motion.acceleration - kGravity);
    const Vec3 ofLever = cross(motion.angular_acceleration, lever) +
                         cross(motion.angular_velocity, cross(motion.angular_velocity, lever));
    return rotate(unit.rotation.conjugate(), ofHead + ofLever);
}

void write(Vec3 value, const Quality &quality, uint32_t unit, int64_t nanos, float out[3]) {
    if (out == nullptr)
        return;
    const double bias = number(Key::ImuBias) * quality.bias;
    const double noise = number(Key::ImuNoise) * quality.noise;
    const double exact[] = {value.x, value.y, value.z};
    for (uint64_t axis = 0; axis < 3; axis++) {
        const uint64_t source =
            mix(static_cast<uint64_t>(number(Key::Seed))) + (quality.number * ML2SIM_UNIT_COUNT + unit) * 3 + axis;
        const double lasting = bias * (2 * uniform(source) - 1);
        const double passing = noise * gaussian(mix(source) + static_cast<uint64_t>(nanos));
        out[axis] = static_cast<float>(exact[axis] + lasting + passing);
    }
}

} // namespace
} // namespace ml2sim

using namespace ml2sim;

int32_t ml2sim_imu(uint32_t unit, int64_t boottime_nanos, float accel[3], float gyro[3], float mag[3]) {
    if (!isUnit(unit))
        return -1;
    const auto motion = HeadPath::current()->at(mlTimeOfBoottime(boottime_nanos));
    const Pose place = mountOf(unit);
    const auto inUnit = [&](Vec3 ofHead) { return rotate(place.rotation.conjugate(), ofHead); };
    write(specificForce(motion, place), kAccelerometer, unit, boottime_nanos, accel);
    write(inUnit(motion.angular_velocity), kGyroscope, unit, boottime_nanos, gyro);
    write(inUnit(rotate(motion.head.rotation.conjugate(), kEarthField)), kMagnetometer, unit, boottime_nanos, mag);
    return 0;
}

float ml2sim_light(int64_t boottime_nanos) {
    constexpr double kTau = 6.283185307179586;
    const double seconds = static_cast<double>(mlTimeOfBoottime(boottime_nanos)) / kSecond;
    return static_cast<float>(300 + 120 * std::sin(kTau * 0.1 * seconds) + 30 * std::sin(kTau * 0.77 * seconds));
}

float ml2sim_pressure(uint32_t unit, int64_t boottime_nanos) {
    if (!isUnit(unit))
        return -1;
    const Pose head = HeadPath::current()->at(mlTimeOfBoottime(boottime_nanos)).head;
    const double height_m = transform(head, mountOf(unit).position).y;
    // The barometric formula of the standard atmosphere (ISO 2533).
    return static_cast<float>(101325 * std::pow(1 - 2.25577e-5 * height_m, 5.25588));
}
