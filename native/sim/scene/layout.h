/** What stands and hangs where in the room. */
#pragma once

#include "scene.h"
#include "surfaces.h"

#include <vector>

namespace ml2sim {

/** Of the finest textures. */
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
/** Whether the box stands between two points; touching an end does not count. */
bool isBetween(const Box &box, Vec3 from, Vec3 to);
/** The walls, then the faces of each box, as WallIndex orders them. */
std::vector<Plane> planesOf(const std::vector<Box> &boxes);
std::vector<Card> hungCards(const std::vector<Plane> &planes);
std::vector<Landmark> landmarksOf(const std::vector<Plane> &planes, const std::vector<Card> &cards);

} // namespace ml2sim
