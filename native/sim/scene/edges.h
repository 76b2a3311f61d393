/** Finds the pixels at edges of surfaces, which are drawn again with finer rays. */
#pragma once

#include "trace.h"

#include <vector>

namespace ml2sim {

class Edges {
  public:
    static constexpr int kRaysPerPixel = 4;

    explicit Edges(const RayTable &rays) : rays_(rays), surface_(rays.x.size()) {}

    /** Keeps what the rays of the pixels from `first` on have met. */
    void note(const Block &block, size_t first);

    /**
     * Calls draw(block, pixels) until all pixels were given that differ from a neighbour; pixel n has rays
     * kRaysPerPixel * n and following of the block, which are not traced yet.
     */
    template <class Draw> void forEachBlock(const Pose &camera, Draw draw) const {
        std::vector<size_t> pixels;
        for (uint32_t v = 1; v + 1 < rays_.height; v++) {
            for (uint32_t u = 1; u + 1 < rays_.width; u++) {
                const size_t pixel = size_t(v) * rays_.width + u;
                if (!isEdge(pixel))
                    continue;
                pixels.push_back(pixel);
                if (pixels.size() == kBlock / kRaysPerPixel)
                    drawAndClear(camera, pixels, draw);
            }
        }
        if (!pixels.empty())
            drawAndClear(camera, pixels, draw);
    }

  private:
    bool isEdge(size_t pixel) const {
        const uint8_t *here = &surface_[pixel];
        const ptrdiff_t row = rays_.width;
        return (here[0] != here[1]) | (here[0] != here[-1]) | (here[0] != here[row]) | (here[0] != here[-row]);
    }

    template <class Draw> void drawAndClear(const Pose &camera, std::vector<size_t> &pixels, Draw draw) const {
        Block block;
        aimFiner(block, camera, pixels);
        draw(block, pixels);
        pixels.clear();
    }

    void aimFiner(Block &block, const Pose &camera, const std::vector<size_t> &pixels) const;

    const RayTable &rays_;
    std::vector<uint8_t> surface_;
};

/** The mean of every kRaysPerPixel values, in place. */
void average(float *values, size_t pixels);

} // namespace ml2sim
