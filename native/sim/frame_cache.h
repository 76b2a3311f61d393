// Rendered frames that are shown in a loop.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "frame_file.h"

namespace ml2sim {

/** Describes the frames to render. Plans with the same name and inputs have the same pixels. */
struct RenderPlan {
    std::string name;   ///< For messages and file names, such as world_left.
    std::string inputs; ///< All parameters that draw depends on.
    size_t frame_bytes; ///< The most that a frame has.
    size_t count;
    /** Renders one frame, always with the same bytes, and returns their number. Called from several threads at once. */
    std::function<size_t(size_t index, uint8_t *frame)> draw;
};

/**
 * The frames of a plan. Each is rendered when it is first needed, and kept in a file of the cache folder, which other
 * processes and later runs share; in memory if there is no folder, or no room. Thread-safe.
 */
class FrameCache {
  public:
    /** Returns the cache of a plan, which lives as long as the process. */
    static std::shared_ptr<FrameCache> of(const RenderPlan &plan);

    /** Use of() instead. `folder` is empty for frames in memory. */
    FrameCache(const RenderPlan &plan, const std::string &folder);
    ~FrameCache();
    FrameCache(const FrameCache &) = delete;
    FrameCache &operator=(const FrameCache &) = delete;

    /** A frame of a cache. */
    struct Place {
        FrameCache *cache; ///< From of(), so it lives as long as the process.
        size_t index;
    };

    static bool areDrawn(const std::vector<Place> &places);

    /**
     * Renders frames by threads of a lower priority, at most two of the process at a time: so what streams beside is
     * not late. Returns false if that was done before.
     */
    static bool draw(const std::vector<Place> &places);

    /** Returns the time that draw() took for frames of this cache, and of others of a capture, the last time; 0 before.
     */
    int64_t drawingNanos() const { return drawingNanos_; }

    /** Returns a frame, rendered now if it was not before; read-only and valid for the life of the cache. */
    const uint8_t *frame(size_t index);

    /** Returns true unless a frame is in memory alone, or there is no folder. */
    bool isInFolder() const { return shared_ != nullptr && own_ == nullptr; }

  private:
    const uint8_t *find(size_t index) const;
    void drawHere(size_t index);
    void keep(size_t index, const uint8_t *frame, size_t bytes);

    const RenderPlan plan_;
    std::unique_ptr<FrameFile> shared_;      ///< Null if there is no folder.
    std::atomic<FrameFile *> own_ = nullptr; ///< For frames that are not in the shared file; null until there are any.
    std::mutex drawing_;
    std::atomic<int64_t> drawingNanos_{0};
};

} // namespace ml2sim
