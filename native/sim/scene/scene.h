/** The room that all simulated cameras look at: what is where, and its painted surfaces. */
#pragma once

#include "geometry.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace ml2sim {

/** Inside of the walls, metres, about the world's origin, where the head starts. */
constexpr Vec3 kRoomLow = {-3.0, -1.5, -3.5};
constexpr Vec3 kRoomHigh = {3.0, 1.3, 3.5};

/** Side of a fiducial: ArUco DICT_4X4_50, its four outer corners saddles between black squares. */
constexpr double kMarkerSide_m = 0.48;

struct Landmark {
    int tag;    ///< ArUco id.
    int corner; ///< 0 to 3, clockwise from the marker's top left, as ArUco orders them.
    Vec3 position;
};

/** A rectangle that bounds what can be seen: origin + a * width * across + b * height * down, a and b from 0 to 1. */
struct Plane {
    Vec3 origin;
    Vec3 across; ///< Unit.
    Vec3 down;   ///< Unit.
    Vec3 normal; ///< Unit, to the side that is seen.
    double width_m;
    double height_m;
};

struct Surfaces;

/** Static and immutable: may be rendered from several threads. Building it takes 0.3 s and 40 MB. */
class Scene {
  public:
    /** `seed` chooses the textures; places of walls, boxes and fiducials are always the same. */
    explicit Scene(uint64_t seed = 1);
    ~Scene();

    const std::vector<Landmark> &landmarks() const { return landmarks_; }
    /** The six walls, then six faces of each box. */
    const std::vector<Plane> &planes() const { return planes_; }

    /** Whether no box stands between two points in the room. */
    bool isClear(Vec3 from, Vec3 to) const;

    /** For the renderer. */
    const Surfaces &surfaces() const { return *surfaces_; }

  private:
    std::vector<Plane> planes_;
    std::vector<Landmark> landmarks_;
    std::unique_ptr<const Surfaces> surfaces_;
};

} // namespace ml2sim
