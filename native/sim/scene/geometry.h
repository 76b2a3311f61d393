/**
 * Points, rotations and poses in the headset's axes: x right, y up, z backward (RUB), right-handed, metres. The world
 * is gravity aligned, y up; a camera or head looks along -z.
 */
#pragma once

#include <cmath>

namespace ml2sim {

struct Vec3 {
    double x = 0;
    double y = 0;
    double z = 0;
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(Vec3 a) { return (1 / length(a)) * a; }

/** A rotation; unit length unless said otherwise. */
struct Quaternion {
    double x = 0;
    double y = 0;
    double z = 0;
    double w = 1;

    static Quaternion about(Vec3 unit_axis, double radians) {
        const Vec3 v = std::sin(radians / 2) * unit_axis;
        return {v.x, v.y, v.z, std::cos(radians / 2)};
    }

    Vec3 vector() const { return {x, y, z}; }
    Quaternion conjugate() const { return {-x, -y, -z, w}; }
};

/** First `b`, then `a`. */
inline Quaternion operator*(Quaternion a, Quaternion b) {
    const Vec3 v = cross(a.vector(), b.vector()) + a.w * b.vector() + b.w * a.vector();
    return {v.x, v.y, v.z, a.w * b.w - dot(a.vector(), b.vector())};
}

inline Vec3 rotate(Quaternion q, Vec3 v) {
    const Vec3 t = 2.0 * cross(q.vector(), v);
    return v + q.w * t + cross(q.vector(), t);
}

/** Maps the thing's own axes to those of its parent: p_parent = rotation * p + position. */
struct Pose {
    Quaternion rotation;
    Vec3 position;
};

inline Vec3 transform(const Pose &pose, Vec3 point) { return rotate(pose.rotation, point) + pose.position; }

/** parent <- b, when `a` is parent <- a and `b` is a <- b. */
inline Pose compose(const Pose &a, const Pose &b) { return {a.rotation * b.rotation, transform(a, b.position)}; }

inline Pose inverse(const Pose &pose) {
    const Quaternion back = pose.rotation.conjugate();
    return {back, rotate(back, -1.0 * pose.position)};
}

} // namespace ml2sim
