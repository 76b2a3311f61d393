#include "scene.h"

#include "light.h"
#include "paint.h"
#include "pyramid.h"

#include <algorithm>

namespace ml2sim {

Scene::Scene(uint64_t seed, TagKind tags) {
    auto surfaces = std::make_unique<Surfaces>();
    surfaces->boxes = standingBoxes();
    planes_ = planesOf(surfaces->boxes);
    std::vector<Card> cards = hungCards(planes_);
    cards.resize(size_t(tagsOf(tags)));
    landmarks_ = landmarksOf(planes_, cards);
    for (int index = 0; index < int(planes_.size()); index++) {
        Canvas canvas = painted(planes_[index], index, cards, tags, seed);
        illuminate(canvas, planes_[index], index, planes_, surfaces->boxes);
        surfaces->all.push_back(addPyramid(canvas, planes_[index], surfaces->texels));
    }
    surfaces_ = std::move(surfaces);
}

bool Scene::isClear(Vec3 from, Vec3 to) const {
    const std::vector<Box> &boxes = surfaces_->boxes;
    return std::none_of(boxes.begin(), boxes.end(), [&](const Box &box) { return isBetween(box, from, to); });
}

} // namespace ml2sim
