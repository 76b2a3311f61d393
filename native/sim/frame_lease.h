// Memory that a caller may read until it gives the memory back.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ml2sim {

/**
 * The memory of the frames that one client of a camera has got. It can be accessed between begin and end; at any other
 * time an access is a segmentation fault. Three regions are used in turn, so a pointer that outlives a release stays
 * invalid even after the next begin. Not thread-safe.
 */
class FrameLease {
  public:
    FrameLease() = default;
    ~FrameLease();
    FrameLease(const FrameLease &) = delete;
    FrameLease &operator=(const FrameLease &) = delete;

    /** Makes a region of at least this size accessible. */
    void begin(size_t bytes);

    /** Returns the next count values of the region, aligned to 64 bytes. */
    template <typename T> T *allocate(size_t count) { return reinterpret_cast<T *>(allocateBytes(count * sizeof(T))); }

    /** Makes the region inaccessible. */
    void end();

    bool isActive() const { return isActive_; }

    /** Returns the size that allocate uses for this many bytes. */
    static constexpr size_t rounded(size_t bytes) { return (bytes + 63) / 64 * 64; }

  private:
    struct Region {
        uint8_t *start = nullptr;
        size_t bytes = 0;
    };
    uint8_t *allocateBytes(size_t bytes);

    Region regions_[3];
    size_t current_ = 0;
    size_t used_ = 0;
    bool isActive_ = false;
};

} // namespace ml2sim
