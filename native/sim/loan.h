// Memory lent to a caller until it gives it back.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ml2sim {

/**
 * The memory of one handle's frames: reachable from begin to end, a segmentation fault at any other time. Three places
 * take turns, so that a pointer kept over a release finds nothing even while the next frames are lent. One thread at
 * a time.
 */
class Loan {
  public:
    Loan() = default;
    ~Loan();
    Loan(const Loan &) = delete;
    Loan &operator=(const Loan &) = delete;

    /** Opens a place of at least this size for takes. */
    void begin(size_t bytes);

    /** The next count values of the place, aligned to 64. */
    template <typename T> T *take(size_t count) { return reinterpret_cast<T *>(takeBytes(count * sizeof(T))); }

    /** Closes the place. */
    void end();

    bool isLent() const { return isLent_; }

    /** What take uses of a place for this many bytes. */
    static constexpr size_t rounded(size_t bytes) { return (bytes + 63) / 64 * 64; }

  private:
    struct Place {
        uint8_t *start = nullptr;
        size_t bytes = 0;
    };
    uint8_t *takeBytes(size_t bytes);

    Place places_[3];
    size_t turn_ = 0;
    size_t used_ = 0;
    bool isLent_ = false;
};

} // namespace ml2sim
