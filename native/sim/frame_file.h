// Frames in a file that several processes read and write at once, or in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace ml2sim {

/** Ends the process, with errno and what failed, unless it is done. */
inline void mustSucceed(bool isDone, const std::string &what) {
    if (isDone)
        return;
    std::perror(("ml2sim: " + what).c_str());
    std::abort();
}

/**
 * A sparse file: the frames, each at whole pages, then one byte for each, which is set once the frame is written. A
 * process that is killed leaves a frame that is not written. Two that write the same frame must write the same bytes.
 * Thread-safe.
 */
class FrameFile {
  public:
    static size_t bytesFor(size_t frame_bytes, size_t count);

    /** Owns `file`, which has bytesFor. If it is kInMemory, the frames are in memory, which they take when written. */
    FrameFile(int file, size_t frame_bytes, size_t count);
    static constexpr int kInMemory = -1;

    ~FrameFile();
    FrameFile(const FrameFile &) = delete;
    FrameFile &operator=(const FrameFile &) = delete;

    /** Returns the frame, read-only and valid for the life of this object; null if it is not written. */
    const uint8_t *find(size_t index) const;

    /** Writes the first bytes of a frame; the rest is zero. Returns false, with errno, if the disk has no room. */
    bool write(size_t index, const uint8_t *frame, size_t bytes);

  private:
    const int file_;
    const size_t stride_;
    const size_t count_;
    uint8_t *start_; ///< The mapping; read-only if it is of a file.
};

} // namespace ml2sim
