#include "layout.h"

#include <algorithm>

namespace ml2sim {
namespace {

struct Standing {
    double x, z, width, height, depth, yaw_degrees;
};

constexpr Standing kStanding[] = {
    {0.95, -1.65, 0.80, 0.88, 0.72, 24},
    {-1.25, -2.00, 0.72, 1.16, 0.64, -17},
    {-2.25, 0.55, 0.80, 0.72, 1.20, 8},
    {2.20, 0.90, 0.72, 0.80, 0.96, -12},
};

/** Columns of cards on the walls: two rows, the centres of each wall's columns evenly spread. */
struct Columns {
    WallIndex wall;
    int count;
    double spacing_m;
};

constexpr Columns kColumns[] = {
    {kFrontWall, 6, 0.96}, {kLeftWall, 7, 0.96}, {kRightWall, 7, 0.96}, {kBackWall, 3, 1.6}};
/** The upper cards' tops, metres below the ceiling; in odd columns a little lower, so that they are less regular. */
constexpr double kRowTop_m[] = {0.40, 1.28};
constexpr double kStagger_m = 0.096;

/** The share of the way between two points, at either end, that may touch a box. */
constexpr double kTouching = 1e-4;

double snapped(double metres) { return kGrid_m * std::round(metres / kGrid_m); }

/** A face of a block about `center`; `axes` are the block's own, in the world. */
Plane face(Vec3 center, const Vec3 axes[3], const double half[3], int axis, double side, double facing) {
    const Vec3 normal = facing * side * axes[axis];
    const Vec3 down = axis == 1 ? normal.y * axes[2] : -1.0 * axes[1];
    const Vec3 across = cross(normal, down);
    const double half_width = axis == 0 ? half[2] : half[0];
    const double half_height = axis == 1 ? half[2] : half[1];
    const Vec3 origin = center + side * half[axis] * axes[axis] - half_width * across - half_height * down;
    return {origin, across, down, normal, 2 * half_width, 2 * half_height};
}

void addFaces(std::vector<Plane> &planes, Vec3 center, Vec3 half, double cos_yaw, double sin_yaw, double facing) {
    const Vec3 axes[3] = {{cos_yaw, 0, -sin_yaw}, {0, 1, 0}, {sin_yaw, 0, cos_yaw}};
    const double halves[3] = {half.x, half.y, half.z};
    for (int axis = 0; axis < 3; axis++) {
        for (const double side : {-1.0, 1.0})
            planes.push_back(face(center, axes, halves, axis, side, facing));
    }
}

Vec3 wide(Float3 v) { return {v.x, v.y, v.z}; }

} // namespace

std::vector<Box> standingBoxes() {
    std::vector<Box> boxes;
    for (const Standing &s : kStanding) {
        const double yaw = s.yaw_degrees * 3.14159265358979323846 / 180;
        const float middle = float(kRoomLow.y + s.height / 2);
        boxes.push_back({{float(s.x), middle, float(s.z)},
                         {float(s.width / 2), float(s.height / 2), float(s.depth / 2)},
                         float(std::cos(yaw)),
                         float(std::sin(yaw))});
    }
    return boxes;
}

bool isBetween(const Box &box, Vec3 from, Vec3 to) {
    const Vec3 start = from - wide(box.center);
    const Vec3 way = to - from;
    const double starts[] = {box.cos_yaw * start.x - box.sin_yaw * start.z, start.y,
                             box.sin_yaw * start.x + box.cos_yaw * start.z};
    const double ways[] = {box.cos_yaw * way.x - box.sin_yaw * way.z, way.y, box.sin_yaw * way.x + box.cos_yaw * way.z};
    const double halves[] = {box.half.x, box.half.y, box.half.z};
    double enter = kTouching, leave = 1 - kTouching;
    for (int axis = 0; axis < 3; axis++) {
        const double a = (-halves[axis] - starts[axis]) / ways[axis];
        const double b = (halves[axis] - starts[axis]) / ways[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter < leave;
}

std::vector<Plane> planesOf(const std::vector<Box> &boxes) {
    std::vector<Plane> planes;
    addFaces(planes, 0.5 * (kRoomLow + kRoomHigh), 0.5 * (kRoomHigh - kRoomLow), 1, 0, -1);
    for (const Box &box : boxes)
        addFaces(planes, wide(box.center), wide(box.half), box.cos_yaw, box.sin_yaw, 1);
    return planes;
}

std::vector<Card> hungCards(const std::vector<Plane> &planes) {
    std::vector<Card> cards;
    for (const Columns &columns : kColumns) {
        for (int column = 0; column < columns.count; column++) {
            const double middle =
                planes[columns.wall].width_m / 2 + (column - (columns.count - 1) / 2.0) * columns.spacing_m;
            const double lower = column % 2 == 1 ? kStagger_m : 0;
            for (const double top : kRowTop_m) {
                cards.push_back(
                    {int(cards.size()), columns.wall, snapped(middle - kCardSide_m / 2), snapped(top + lower)});
            }
        }
    }
    // One face of each box, that which looks at where the head starts.
    constexpr WallIndex kBoxFaces[] = {kBackWall, kBackWall, kRightWall, kLeftWall};
    for (int box = 0; box < 4; box++) {
        const int surface = kWallCount * (1 + box) + kBoxFaces[box];
        const Plane &plane = planes[surface];
        cards.push_back({int(cards.size()), surface, snapped((plane.width_m - kCardSide_m) / 2), kGrid_m});
    }
    return cards;
}

std::vector<Landmark> landmarksOf(const std::vector<Plane> &planes, const std::vector<Card> &cards) {
    constexpr double kMargin_m = (kCardSide_m - kMarkerSide_m) / 2;
    constexpr double kAcross[] = {0, kMarkerSide_m, kMarkerSide_m, 0};
    constexpr double kDown[] = {0, 0, kMarkerSide_m, kMarkerSide_m};
    std::vector<Landmark> landmarks;
    for (const Card &card : cards) {
        const Plane &plane = planes[card.surface];
        for (int corner = 0; corner < 4; corner++) {
            const Vec3 position = plane.origin + (card.across_m + kMargin_m + kAcross[corner]) * plane.across +
                                  (card.down_m + kMargin_m + kDown[corner]) * plane.down;
            landmarks.push_back({card.tag, corner, position});
        }
    }
    return landmarks;
}

} // namespace ml2sim
