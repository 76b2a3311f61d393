/** The layout of the room: boxes, cards, fiducials and landmarks. */
#pragma once

#include "geometry.h"
#include "surfaces.h"

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

/** Side of a texel of the finest textures. */
constexpr double kTexel_m = 0.004;
/** Edges of fiducials lie between texels of the first three levels: smoothing then moves no corner. */
constexpr double kGrid_m = 4 * kTexel_m;
/** Black squares of one cell touch the marker's corners; a white card carries them all. */
constexpr double kMarkerCell_m = kMarkerSide_m / 6;
constexpr double kCardSide_m = kMarkerSide_m + 2 * kMarkerCell_m + 2 * kGrid_m;

/** A fiducial on a surface: where its card's top left is, metres from the surface's top left. */
struct Card {
    int tag;
    int surface;
    double across_m;
    double down_m;
};

std::vector<Box> standingBoxes();
/** Returns true if the box stands between two points; touching an end does not count. */
bool isBetween(const Box &box, Vec3 from, Vec3 to);
/** The walls, then the faces of each box, as WallIndex orders them. */
std::vector<Plane> planesOf(const std::vector<Box> &boxes);
std::vector<Card> hungCards(const std::vector<Plane> &planes);
std::vector<Landmark> landmarksOf(const std::vector<Plane> &planes, const std::vector<Card> &cards);

} // namespace ml2sim
