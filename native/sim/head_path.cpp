#include "head_path.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <sstream>

#include "clock.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** The start of a path that does not loop, before start() was called. */
constexpr int64_t kNotStarted = INT64_MAX;

std::mutex mutex;
std::shared_ptr<HeadPath> currentPath;

std::string contents(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream out;
    out << file.rdbuf();
    return out.str();
}

uint64_t seed() { return static_cast<uint64_t>(number(Key::Seed)); }

TagKind tagKind() {
    constexpr const char *kNames[] = {"4X4_50", "5X5_100", "36h11", "QR"};
    const auto found = std::find(std::begin(kNames), std::end(kNames), text(Key::Tags));
    return static_cast<TagKind>(found - std::begin(kNames));
}

} // namespace

HeadPath::HeadPath(Trajectory trajectory, bool isLoop, std::string inputs)
    : trajectory_(std::move(trajectory)), isLoop_(isLoop), isStill_(isOn(Key::StillImages)),
      loopNanos_(std::llround(trajectory_.durationSeconds()) * kSecond), inputs_(std::move(inputs)),
      start_(kNotStarted) {}

std::shared_ptr<HeadPath> HeadPath::fromKeys() {
    const auto room = "seed=" + std::to_string(seed()) + " tags=" + text(Key::Tags);
    const auto path = text(Key::Trajectory);
    if (!path.empty())
        return std::shared_ptr<HeadPath>(
            new HeadPath(Trajectory::fromTum(path), false, room + " tum=" + contents(path)));
    const double loop_s = number(Key::LoopSeconds);
    return std::shared_ptr<HeadPath>(
        new HeadPath(Trajectory::looped(seed(), loop_s), true, room + " loop=" + std::to_string(loop_s)));
}

std::shared_ptr<HeadPath> HeadPath::current() {
    const std::lock_guard lock(mutex);
    return currentPath;
}

std::string HeadPath::refresh() {
    try {
        auto next = fromKeys();
        const std::lock_guard lock(mutex);
        currentPath = next;
        return "";
    } catch (const TrajectoryError &error) {
        return error.what();
    }
}

Motion HeadPath::at(int64_t mltime) const { return trajectory_.at(secondsAt(mltime)); }

double HeadPath::secondsAt(int64_t mltime) const {
    if (isLoop_)
        return static_cast<double>(mltime % loopNanos_) / kSecond;
    const int64_t start = start_;
    return start == kNotStarted ? 0 : static_cast<double>(mltime - start) / kSecond;
}

void HeadPath::start() {
    int64_t expected = kNotStarted;
    start_.compare_exchange_strong(expected, (mlTimeNow() / kSecond + 1) * kSecond);
}

size_t HeadPath::frameCount(uint32_t rate_hz) const {
    if (isStill_)
        return 1;
    if (isLoop_)
        return static_cast<size_t>(loopNanos_ / kSecond) * rate_hz;
    return static_cast<size_t>(std::ceil(trajectory_.durationSeconds() * rate_hz)) + 1;
}

size_t HeadPath::frameIndex(int64_t index, uint32_t rate_hz) const {
    const auto count = static_cast<int64_t>(frameCount(rate_hz));
    if (isLoop_ || isStill_)
        return static_cast<size_t>(index % count);
    const int64_t start = start_;
    if (start == kNotStarted)
        return 0;
    return static_cast<size_t>(std::clamp<int64_t>(index - start / kSecond * rate_hz, 0, count - 1));
}

Motion HeadPath::atFrame(size_t index, uint32_t rate_hz) const {
    return trajectory_.at(static_cast<double>(captureTime(static_cast<int64_t>(index), rate_hz)) / kSecond);
}

std::shared_ptr<const Scene> HeadPath::scene() {
    static std::mutex building;
    // Never destroyed: frames may be drawn while the process ends.
    static auto &scene = *new std::shared_ptr<const Scene>;
    static std::pair<uint64_t, TagKind> built;
    const std::lock_guard lock(building);
    const std::pair wanted(seed(), tagKind());
    if (!scene || built != wanted) {
        built = wanted;
        scene = std::make_shared<const Scene>(wanted.first, wanted.second);
    }
    return scene;
}

int64_t captureTime(int64_t index, uint32_t rate_hz) { return index * kSecond / rate_hz; }

int64_t captureIndex(int64_t mltime, uint32_t rate_hz) { return ((mltime + 1) * rate_hz + kSecond - 1) / kSecond - 1; }

} // namespace ml2sim
