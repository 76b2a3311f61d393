// Rendered frames that are shown in a loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace ml2sim {

/** Describes the frames to render. Plans with the same name and inputs have the same pixels. */
struct RenderPlan {
    std::string name;   ///< For messages and file names, such as world_left.
    std::string inputs; ///< All parameters that draw depends on.
    size_t frame_bytes;
    size_t count;
    /** Renders one frame. Called from several threads at once. */
    std::function<void(size_t index, uint8_t *frame)> draw;
};

/**
 * Holds the rendered frames of a plan in shared memory. With a real clock, two threads render all frames before the
 * first one is shown, which takes seconds, unless the cache folder has them. With a manual clock, where rendering takes
 * no simulated time, each frame is rendered when it is first read.
 */
class FrameCache {
  public:
    /** Returns the cache of a plan; renders it if there is none. Thread-safe; concurrent calls for one plan wait. */
    static std::shared_ptr<FrameCache> of(const RenderPlan &plan);

    /** Returns true while a thread waits for rendered frames. Thread-safe. */
    static bool isDrawing();

    FrameCache(const RenderPlan &plan, bool drawsAhead);
    ~FrameCache();
    FrameCache(const FrameCache &) = delete;
    FrameCache &operator=(const FrameCache &) = delete;

    /** Returns a frame, read-only and valid for the life of the cache. Thread-safe. */
    const uint8_t *frame(size_t index);
    size_t count() const { return plan_.count; }

  private:
    void map(int file);
    bool load(const std::string &path);
    void drawAll();

    struct Drawn;
    RenderPlan plan_;
    size_t stride_;
    uint8_t *frames_ = nullptr;
    std::unique_ptr<Drawn> drawn_; ///< Null when all frames are rendered.
};

} // namespace ml2sim
