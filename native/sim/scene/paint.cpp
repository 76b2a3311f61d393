#include "paint.h"

#include "hash.h"

namespace ml2sim {
namespace {

constexpr float kPi = 3.1415927f;
constexpr Rgb kInk = {0.07f, 0.07f, 0.08f};
constexpr Rgb kPaper = {0.96f, 0.96f, 0.94f};
constexpr float kLampGlow = 3.0f;

constexpr Rgb kWallColors[kWallCount] = {{0.55f, 0.66f, 0.72f}, {0.80f, 0.68f, 0.52f}, {0.62f, 0.45f, 0.30f},
                                         {0.86f, 0.86f, 0.83f}, {0.83f, 0.79f, 0.70f}, {0.66f, 0.36f, 0.28f}};
constexpr Rgb kBoxColors[] = {
    {0.75f, 0.57f, 0.35f}, {0.30f, 0.52f, 0.48f}, {0.70f, 0.36f, 0.27f}, {0.38f, 0.42f, 0.60f}};
constexpr Rgb kChipColors[] = {{0.12f, 0.14f, 0.18f}, {0.93f, 0.91f, 0.86f}, {0.78f, 0.31f, 0.22f},
                               {0.17f, 0.42f, 0.47f}, {0.90f, 0.71f, 0.28f}, {0.30f, 0.30f, 0.46f},
                               {0.47f, 0.60f, 0.36f}, {0.40f, 0.25f, 0.18f}};

Rgb chipColor(Random &random) { return kChipColors[random.below(std::size(kChipColors))]; }
float shade(Random &random, float spread) { return random.uniform(1 - spread, 1 + spread); }

Rectangle wholeOf(const Canvas &canvas) {
    return {0, 0, canvas.width() * canvas.texel(), canvas.height() * canvas.texel()};
}

/** Scatters polygons, as in terrazzo: `per_m2` of them, their radii spread over a wide range. */
void scatterChips(Canvas &canvas, const Rectangle &area, float per_m2, float smallest_m, float largest_m,
                  Random &random) {
    const int count = int(per_m2 * area.width * area.height);
    for (int n = 0; n < count; n++) {
        const Spot center = {area.left + random.uniform(0, area.width), area.top + random.uniform(0, area.height)};
        const float scale = random.uniform(0, 1);
        const float radius = smallest_m * std::pow(largest_m / smallest_m, scale * scale);
        canvas.paint(Polygon{center, radius, 3 + random.below(4), random.uniform(0, kPi)}, chipColor(random));
    }
}

void paintBooks(Canvas &canvas, const Rectangle &shelf, Random &random) {
    canvas.paint(shelf, {0.25f, 0.17f, 0.11f});
    const float floor = shelf.top + shelf.height - 0.03f;
    for (float x = shelf.left + 0.03f; x < shelf.left + shelf.width - 0.08f;) {
        const float width = random.uniform(0.024f, 0.064f);
        const float height = (shelf.height - 0.05f) * random.uniform(0.65f, 0.97f);
        const Rgb cover = shade(random, 0.3f) * chipColor(random);
        canvas.paint(Rectangle{x, floor - height, width, height}, cover);
        canvas.paint(
            Rectangle{x + 0.2f * width, floor - height * random.uniform(0.7f, 0.9f), 0.6f * width, 0.1f * height},
            random.below(2) ? kPaper : kInk);
        x += width + 0.004f;
    }
}

void paintBricks(Canvas &canvas, Rgb color, Random &random) {
    constexpr float kWidth = 0.24f, kHeight = 0.08f, kJoint = 0.012f;
    const Rectangle wall = wholeOf(canvas);
    canvas.paint(wall, {0.72f, 0.69f, 0.64f});
    for (int row = 0; row * kHeight < wall.height; row++) {
        for (int column = -1; column * kWidth < wall.width; column++) {
            const Rectangle brick = {(column + 0.5f * (row % 2)) * kWidth, row * kHeight, kWidth - kJoint,
                                     kHeight - kJoint};
            canvas.paint(brick, shade(random, 0.28f) * color);
        }
    }
}

void paintPanels(Canvas &canvas, const Rectangle &area, Random &random) {
    constexpr float kWidth = 0.5f;
    for (float x = area.left; x < area.left + area.width; x += kWidth) {
        const Rgb wood = shade(random, 0.15f) * Rgb{0.45f, 0.30f, 0.19f};
        canvas.paint(Rectangle{x, area.top, kWidth, area.height}, 0.7f * wood);
        canvas.paint(Rectangle{x + 0.02f, area.top + 0.02f, kWidth - 0.04f, area.height - 0.04f}, wood);
        canvas.paint(Rectangle{x + 0.08f, area.top + 0.08f, kWidth - 0.16f, area.height - 0.16f}, 1.25f * wood);
    }
}

void paintMosaic(Canvas &canvas, const Rectangle &area, Random &random) {
    constexpr float kTile = 0.08f;
    for (float y = area.top; y < area.top + area.height - kTile / 2; y += kTile) {
        for (float x = area.left; x < area.left + area.width; x += kTile) {
            canvas.paint(Rectangle{x, y, kTile, kTile}, {0.85f, 0.83f, 0.78f});
            canvas.paint(Rectangle{x, y, kTile - 0.008f, kTile - 0.008f}, shade(random, 0.2f) * chipColor(random));
        }
    }
}

/** Flags on a line below the ceiling. */
void paintPennants(Canvas &canvas, Random &random) {
    const Rectangle wall = wholeOf(canvas);
    canvas.paint(Rectangle{0, 0.14f, wall.width, 0.012f}, kInk);
    for (float x = 0.15f; x < wall.width; x += 0.24f) {
        canvas.paint(Polygon{{x, 0.20f}, 0.11f, 3, -kPi / 2}, chipColor(random));
        canvas.paint(Disc{{x, 0.185f}, 0.025f}, kPaper);
    }
}

void paintPlanks(Canvas &canvas, Rgb color, Random &random) {
    constexpr float kWidth = 0.15f;
    const Rectangle floor = wholeOf(canvas);
    for (float x = 0; x < floor.width; x += kWidth) {
        for (float y = random.uniform(-1.2f, 0); y < floor.height;) {
            const float length = random.uniform(0.7f, 1.4f);
            canvas.paint(Rectangle{x, y, kWidth, length}, 0.45f * color);
            canvas.paint(Rectangle{x, y, kWidth - 0.008f, length - 0.008f}, shade(random, 0.25f) * color);
            for (int knot = random.below(4); knot > 0; knot--) {
                const Spot at = {x + random.uniform(0.02f, kWidth - 0.03f), y + random.uniform(0.05f, length)};
                canvas.paint(Disc{at, random.uniform(0.006f, 0.02f)}, 0.4f * color);
            }
            y += length;
        }
    }
}

void paintRug(Canvas &canvas, const Rectangle &rug, Random &random) {
    constexpr Rgb kBands[] = {
        {0.55f, 0.14f, 0.14f}, {0.86f, 0.78f, 0.62f}, {0.16f, 0.22f, 0.34f}, {0.62f, 0.18f, 0.16f}};
    float inset = 0;
    for (const Rgb band : kBands) {
        canvas.paint(Rectangle{rug.left + inset, rug.top + inset, rug.width - 2 * inset, rug.height - 2 * inset}, band);
        inset += 0.09f;
    }
    for (float y = 0.42f; y < rug.height - 0.3f; y += 0.24f) {
        for (float x = 0.42f; x < rug.width - 0.3f; x += 0.24f) {
            const Spot center = {rug.left + x, rug.top + y};
            canvas.paint(Polygon{center, 0.11f, 4, 0}, shade(random, 0.2f) * chipColor(random));
            canvas.paint(Polygon{center, random.uniform(0.03f, 0.07f), 4, 0}, chipColor(random));
        }
    }
}

void paintCeiling(Canvas &canvas, Random &random) {
    constexpr float kTile = 0.6f;
    const Rectangle ceiling = wholeOf(canvas);
    for (float y = 0; y < ceiling.height; y += kTile) {
        for (float x = 0; x < ceiling.width; x += kTile) {
            canvas.paint(Rectangle{x, y, kTile, kTile}, {0.55f, 0.55f, 0.54f});
            canvas.paint(Rectangle{x, y, kTile - 0.024f, kTile - 0.024f}, shade(random, 0.06f) * kWallColors[kCeiling]);
        }
    }
    for (int n = int(40 * ceiling.width * ceiling.height); n > 0; n--) {
        const Spot spot = {random.uniform(0, ceiling.width), random.uniform(0, ceiling.height)};
        canvas.paint(Disc{spot, random.uniform(0.008f, 0.03f)}, random.uniform(0.3f, 0.6f) * kWallColors[kCeiling]);
    }
    for (const Rectangle &lamp : lamps()) {
        canvas.paint(Rectangle{lamp.left - 0.06f, lamp.top - 0.06f, lamp.width + 0.12f, lamp.height + 0.12f},
                     {0.2f, 0.2f, 0.2f});
        canvas.paint(lamp, kLampGlow * Rgb{1, 0.98f, 0.92f});
    }
}

void paintCrate(Canvas &canvas, Rgb color, Random &random) {
    const Rectangle face = wholeOf(canvas);
    const float board = face.height / 5;
    for (int n = 0; n < 5; n++) {
        canvas.paint(Rectangle{0, n * board, face.width, board}, 0.5f * color);
        canvas.paint(Rectangle{0, n * board, face.width, board - 0.01f}, shade(random, 0.15f) * color);
    }
    for (const float x : {0.0f, face.width - 0.08f})
        canvas.paint(Rectangle{x, 0, 0.08f, face.height}, 0.8f * color);
    scatterChips(canvas, face, 45, 0.012f, 0.05f, random);
}

void paintWall(Canvas &canvas, int wall, Random &random) {
    const Rectangle all = wholeOf(canvas);
    const Rectangle foot = {0, 2.2f, all.width, 0.52f};
    switch (wall) {
    case kLeftWall:
        scatterChips(canvas, all, 45, 0.012f, 0.10f, random);
        paintBooks(canvas, foot, random);
        break;
    case kRightWall:
        scatterChips(canvas, all, 45, 0.012f, 0.10f, random);
        paintMosaic(canvas, foot, random);
        break;
    case kFrontWall:
        scatterChips(canvas, all, 40, 0.010f, 0.07f, random);
        paintPanels(canvas, foot, random);
        paintPennants(canvas, random);
        break;
    default:
        paintBricks(canvas, kWallColors[wall], random);
    }
    canvas.paint(Rectangle{0, all.height - 0.08f, all.width, 0.08f}, {0.22f, 0.15f, 0.10f});
}

void paintFloor(Canvas &canvas, Random &random) {
    paintPlanks(canvas, kWallColors[kFloor], random);
    paintRug(canvas, {1.7f, 1.5f, 2.6f, 3.6f}, random);
}

void paintGrain(Canvas &canvas, uint64_t seed) {
    canvas.grain(seed, 0.8f, 0.10f);
    canvas.grain(seed + 1, 0.16f, 0.08f);
    canvas.grain(seed + 2, 0.040f, 0.08f);
    canvas.grain(seed + 3, 0.012f, 0.07f);
}

/** Black squares at the marker's corners make saddles of them. Readers of other dictionaries expect white there. */
void paintSquares(Canvas &canvas, float left, float top, float marker) {
    const float cell = float(kMarkerCell_m);
    for (const float x : {left - cell, left + marker}) {
        for (const float y : {top - cell, top + marker})
            canvas.paint(Rectangle{x, y, cell, cell}, kInk);
    }
}

void paintCard(Canvas &canvas, const Card &card, TagKind tags) {
    const float side = float(kCardSide_m), marker = float(kMarkerSide_m), margin = (side - marker) / 2;
    const float left = float(card.across_m) + margin, top = float(card.down_m) + margin;
    const int cells = cellsOf(tags);
    const auto edge = [&](int cell) { return float(kTexel_m * std::round(marker / float(kTexel_m) * cell / cells)); };
    canvas.paint(Rectangle{float(card.across_m), float(card.down_m), side, side}, kPaper);
    for (int row = 0; row < cells; row++) {
        for (int column = 0; column < cells; column++) {
            if (!isWhite(tags, card.tag, row, column))
                canvas.paint(Rectangle{left + edge(column), top + edge(row), edge(column + 1) - edge(column),
                                       edge(row + 1) - edge(row)},
                             kInk);
        }
    }
    if (tags == TagKind::Aruco4x4)
        paintSquares(canvas, left, top, marker);
}

} // namespace

double texelOf(int surface) { return surface == kFloor || surface == kCeiling ? 2 * kTexel_m : kTexel_m; }

const std::vector<Rectangle> &lamps() {
    static const std::vector<Rectangle> four = {
        {1.2f, 1.4f, 0.9f, 0.9f}, {3.9f, 1.4f, 0.9f, 0.9f}, {1.2f, 4.6f, 0.9f, 0.9f}, {3.9f, 4.6f, 0.9f, 0.9f}};
    return four;
}

Canvas painted(const Plane &plane, int surface, const std::vector<Card> &cards, TagKind tags, uint64_t seed) {
    Random random(mix(seed) + mix(uint64_t(surface) + 1000));
    const int box = surface / kWallCount - 1;
    const Rgb color = surface < kWallCount ? kWallColors[surface] : kBoxColors[box];
    Canvas canvas(plane.width_m, plane.height_m, texelOf(surface), color);
    if (surface == kFloor)
        paintFloor(canvas, random);
    else if (surface == kCeiling)
        paintCeiling(canvas, random);
    else if (surface < kWallCount)
        paintWall(canvas, surface, random);
    else
        paintCrate(canvas, color, random);
    paintGrain(canvas, random.next());
    for (const Card &card : cards) {
        if (card.surface == surface)
            paintCard(canvas, card, tags);
    }
    return canvas;
}

} // namespace ml2sim
