#include "frame_lease.h"

#include <sys/mman.h>

#include <cstdio>
#include <cstdlib>

#include "frame_file.h"

namespace ml2sim {
namespace {

constexpr size_t kPage = 4096;

} // namespace

FrameLease::~FrameLease() {
    for (auto &region : regions_)
        if (region.start != nullptr)
            munmap(region.start, region.bytes);
}

void FrameLease::begin(size_t bytes) {
    current_ = (current_ + 1) % 3;
    auto &region = regions_[current_];
    if (region.start == nullptr || region.bytes < bytes) {
        if (region.start != nullptr)
            munmap(region.start, region.bytes);
        region.bytes = bytes / kPage * kPage + kPage;
        void *memory = mmap(nullptr, region.bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        mustSucceed(memory != MAP_FAILED, "mmap");
        region.start = static_cast<uint8_t *>(memory);
    }
    mustSucceed(mprotect(region.start, region.bytes, PROT_READ | PROT_WRITE) == 0, "mprotect");
    used_ = 0;
    isActive_ = true;
}

uint8_t *FrameLease::allocateBytes(size_t bytes) {
    auto &region = regions_[current_];
    const size_t offset = used_;
    used_ += rounded(bytes);
    if (used_ > region.bytes) {
        std::fprintf(stderr, "ml2sim: a lease has %zu bytes, %zu are needed\n", region.bytes, used_);
        std::abort();
    }
    return region.start + offset;
}

void FrameLease::end() {
    auto &region = regions_[current_];
    mustSucceed(mprotect(region.start, region.bytes, PROT_NONE) == 0, "mprotect");
    isActive_ = false;
}

} // namespace ml2sim
