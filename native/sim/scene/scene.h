/** The room that all simulated cameras look at: what is where, and its painted surfaces. */
#pragma once

#include "fiducials.h"
#include "layout.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace ml2sim {

/** Static and immutable: may be rendered from several threads. Building it takes 0.3 s and 40 MB. */
class Scene {
  public:
    /** `seed` chooses the textures; places of walls, boxes and fiducials are always the same. */
    explicit Scene(uint64_t seed = 1, TagKind tags = TagKind::Aruco4x4);

    const std::vector<Landmark> &landmarks() const { return landmarks_; }
    /** The six walls, then six faces of each box. */
    const std::vector<Plane> &planes() const { return planes_; }

    /** Returns true if no box stands between two points in the room. */
    bool isClear(Vec3 from, Vec3 to) const;

    /** For the renderer. */
    const Surfaces &surfaces() const { return *surfaces_; }

  private:
    std::vector<Plane> planes_;
    std::vector<Landmark> landmarks_;
    std::unique_ptr<const Surfaces> surfaces_;
};

} // namespace ml2sim
