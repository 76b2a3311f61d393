#include "loan.h"

#include <sys/mman.h>

#include <cstdio>
#include <cstdlib>

namespace ml2sim {
namespace {

constexpr size_t kPage = 4096;

void mustSucceed(bool isDone, const char *what) {
    if (isDone)
        return;
    std::perror(what);
    std::abort();
}

} // namespace

Loan::~Loan() {
    for (auto &place : places_)
        if (place.start != nullptr)
            munmap(place.start, place.bytes);
}

void Loan::begin(size_t bytes) {
    turn_ = (turn_ + 1) % 3;
    auto &place = places_[turn_];
    if (place.start == nullptr || place.bytes < bytes) {
        if (place.start != nullptr)
            munmap(place.start, place.bytes);
        place.bytes = bytes / kPage * kPage + kPage;
        void *memory = mmap(nullptr, place.bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        mustSucceed(memory != MAP_FAILED, "ml2sim: mmap");
        place.start = static_cast<uint8_t *>(memory);
    }
    mustSucceed(mprotect(place.start, place.bytes, PROT_READ | PROT_WRITE) == 0, "ml2sim: mprotect");
    used_ = 0;
    isLent_ = true;
}

uint8_t *Loan::takeBytes(size_t bytes) {
    auto &place = places_[turn_];
    const size_t offset = used_;
    used_ += rounded(bytes);
    if (used_ > place.bytes) {
        std::fprintf(stderr, "ml2sim: a loan of %zu bytes is too small for %zu\n", place.bytes, used_);
        std::abort();
    }
    return place.start + offset;
}

void Loan::end() {
    auto &place = places_[turn_];
    mustSucceed(mprotect(place.start, place.bytes, PROT_NONE) == 0, "ml2sim: mprotect");
    isLent_ = false;
}

} // namespace ml2sim
