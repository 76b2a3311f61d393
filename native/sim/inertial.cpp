// ml2sim_imu, ml2sim_light, ml2sim_pressure: measurements of the inertial units, light sensor and barometers.
#include <cmath>

#include "clock.h"
#include "exposure.h"
#include "head_path.h"
#include "imperfections.h"
#include "ml2sim.h"
#include "scene/hash.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** Standard gravity (CGPM 1901). */
constexpr Vec3 kGravity = {0, -9.80665, 0};
/** The magnetic field of central Europe (WMM) in tesla, with magnetic north along -z of the scene. */
constexpr Vec3 kEarthField = {0, -42e-6, -22e-6};

/**
 * A kind of measurement: its bias for imu_bias=1, and for noise=1 the densities of its white noise (1 over
 * sqrt(Hz)) and of the walk of its bias (1 over sqrt(s)), which do not depend on the rate.
 */
struct Quality {
    uint64_t number;
    double bias;
    double density;
    double walk;
    double rate_hz; ///< The rate of the simulated SensorManager.
};
// The BMI160 of the TUM-VI data set (Schubert et al. 2018), a consumer's part, as OpenVINS's config/tum_vi has it.
constexpr Quality kAccelerometer = {0, 0.05, 2.8e-3, 8.6e-4, 200};
constexpr Quality kGyroscope = {1, 0.005, 1.6e-4, 2.2e-5, 200};
/** Assumed: 3e-7 T for each sample. */
constexpr Quality kMagnetometer = {2, 0, 4.2e-8, 0, 50};
/** After 73 minutes a bias is forgotten, so that it does not grow with the age of the machine. */
constexpr int kForgotten_log2 = 42;

bool isUnit(uint32_t unit) { return unit < ML2SIM_UNIT_COUNT; }

Imu imuOf(uint32_t unit) {
    constexpr Imu kUnits[] = {Imu::Left, Imu::Right, Imu::ComputePack};
    return kUnits[unit];
}

Vec3 specificForce(const Motion &motion, const UnitInHead &unit) {
    const Vec3 &turn = motion.angular_velocity, &lever = unit.place.position;
    const Vec3 ofHead = rotate(motion.head.rotation.conjugate(), motion.acceleration - kGravity);
    const Vec3 ofLever = cross(motion.angular_acceleration, lever) + cross(turn, cross(turn, lever));
    const Vec3 ofItself = unit.acceleration + 2.0 * cross(turn, unit.velocity);
    return rotate(unit.place.rotation.conjugate(), ofHead + ofLever + ofItself);
}

void write(Vec3 value, const Quality &quality, uint32_t unit, int64_t nanos, float out[3]) {
    if (out == nullptr)
        return;
    const double bias = number(Key::ImuBias) * quality.bias, noise = number(Key::Noise);
    const double exact[] = {value.x, value.y, value.z};
    for (uint64_t axis = 0; axis < 3; axis++) {
        const uint64_t source = noiseSource((quality.number * ML2SIM_UNIT_COUNT + unit) * 3 + axis);
        double error = bias * symmetric(source);
        if (noise != 0)
            error += noise * quality.density * std::sqrt(quality.rate_hz) *
                     gaussian(mix(source) + static_cast<uint64_t>(nanos));
        if (noise != 0 && quality.walk != 0)
            error += noise * quality.walk * wiener(source, nanos, kForgotten_log2);
        out[axis] = static_cast<float>(exact[axis] + error);
    }
}

} // namespace
} // namespace ml2sim

using namespace ml2sim;

int32_t ml2sim_imu(uint32_t unit, int64_t boottime_nanos, float accel[3], float gyro[3], float mag[3]) {
    if (!isUnit(unit))
        return -1;
    const Imu imu = imuOf(unit);
    const int64_t time = mlTimeOfBoottime(boottime_nanos - lateNanos(imu));
    const auto motion = HeadPath::current()->at(time);
    const auto place = unitInHead(imu, time);
    const auto inUnit = [&](Vec3 ofHead) { return rotate(place.place.rotation.conjugate(), ofHead); };
    write(specificForce(motion, place), kAccelerometer, unit, boottime_nanos, accel);
    write(inUnit(motion.angular_velocity + place.angular_velocity), kGyroscope, unit, boottime_nanos, gyro);
    const Vec3 field = number(Key::AssumeMagneticField) * kEarthField;
    write(inUnit(rotate(motion.head.rotation.conjugate(), field)), kMagnetometer, unit, boottime_nanos, mag);
    return 0;
}

float ml2sim_light(int64_t boottime_nanos) {
    return static_cast<float>(lightAt(*HeadPath::current(), mlTimeOfBoottime(boottime_nanos)));
}

float ml2sim_pressure(uint32_t unit, int64_t boottime_nanos) {
    if (!isUnit(unit))
        return -1;
    const Pose head = HeadPath::current()->at(mlTimeOfBoottime(boottime_nanos)).head;
    const double height_m = transform(head, mountInHead(imuOf(unit)).position).y;
    // The barometric formula of the standard atmosphere (ISO 2533).
    return static_cast<float>(101325 * std::pow(1 - 2.25577e-5 * height_m, 5.25588));
}
