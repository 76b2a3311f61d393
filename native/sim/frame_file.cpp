#include "frame_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace ml2sim {
namespace {

constexpr size_t kPage = 4096;

size_t rounded(size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

/** Through the file, since a full disk is an error of this call, but ends a process that writes to mapped memory. */
bool writeAll(int file, const uint8_t *from, size_t bytes, size_t at) {
    while (bytes > 0) {
        const ssize_t written = pwrite(file, from, bytes, static_cast<off_t>(at));
        if (written < 0 && errno != EINTR)
            return false;
        if (written > 0) {
            from += written;
            at += static_cast<size_t>(written);
            bytes -= static_cast<size_t>(written);
        }
    }
    return true;
}

} // namespace

size_t FrameFile::bytesFor(size_t frame_bytes, size_t count) { return rounded(frame_bytes) * count + rounded(count); }

FrameFile::FrameFile(int file, size_t frame_bytes, size_t count)
    : file_(file), stride_(rounded(frame_bytes)), count_(count) {
    const bool isFile = file != kInMemory;
    void *memory = mmap(nullptr, bytesFor(frame_bytes, count), isFile ? PROT_READ : PROT_READ | PROT_WRITE,
                        isFile ? MAP_SHARED : MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, file, 0);
    mustSucceed(memory != MAP_FAILED,
                "cannot map " + std::to_string(bytesFor(frame_bytes, count)) + " bytes of frames");
    start_ = static_cast<uint8_t *>(memory);
}

FrameFile::~FrameFile() {
    munmap(start_, stride_ * count_ + rounded(count_));
    if (file_ != kInMemory)
        close(file_);
}

const uint8_t *FrameFile::find(size_t index) const {
    const bool isWritten = __atomic_load_n(start_ + stride_ * count_ + index, __ATOMIC_ACQUIRE) != 0;
    return isWritten ? start_ + stride_ * index : nullptr;
}

bool FrameFile::write(size_t index, const uint8_t *frame, size_t bytes) {
    constexpr uint8_t kWritten = 1;
    if (file_ == kInMemory) {
        std::memcpy(start_ + stride_ * index, frame, bytes);
        __atomic_store_n(start_ + stride_ * count_ + index, kWritten, __ATOMIC_RELEASE);
        return true;
    }
    return writeAll(file_, frame, bytes, stride_ * index) && writeAll(file_, &kWritten, 1, stride_ * count_ + index);
}

} // namespace ml2sim
