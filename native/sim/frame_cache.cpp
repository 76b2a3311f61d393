#include "frame_cache.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cinttypes>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <map>
#include <thread>

#include "cache_folder.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** Part of the inputs of every plan. Increase it when the renderer or the layout of the files changes. */
constexpr int kRendererVersion = 2;

constexpr size_t kDrawingThreads = 2;
/** Added to the niceness of the process, not of the thread that asks, for the threads that draw. */
constexpr int kNiceness = 5;

/** Lets two threads of the process draw, in the order in which they ask. More slow each other, and come too late. */
class Turns {
  public:
    void take() {
        std::unique_lock lock(mutex_);
        const uint64_t turn = taken_++;
        given_.wait(lock, [&] { return turn < done_ + kDrawingThreads; });
    }
    void leave() {
        const std::lock_guard lock(mutex_);
        done_++;
        given_.notify_all();
    }

  private:
    std::mutex mutex_;
    std::condition_variable given_;
    uint64_t taken_ = 0, done_ = 0;
};

/** FNV-1a. */
uint64_t hashOf(const std::string &text) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const unsigned char c : text)
        hash = (hash ^ c) * 0x100000001b3;
    return hash;
}

void sayNotKept(const std::string &name) {
    std::fprintf(stderr, "ml2sim: cannot keep the frames of %s in the cache: %s; this process keeps them in memory\n",
                 name.c_str(), std::strerror(errno));
}

void sayUnlessWhole(const FrameFile &file, const char *name, size_t count) {
    size_t rendered = 0;
    for (size_t i = 0; i < count; i++)
        rendered += file.find(i) != nullptr ? 1 : 0;
    if (rendered < count)
        std::fprintf(stderr, "ml2sim: %s: %zu of %zu frames are rendered\n", name, rendered, count);
}

std::unique_ptr<FrameFile> openShared(const RenderPlan &plan, const std::string &folder) {
    if (folder.empty())
        return nullptr;
    char name[96];
    std::snprintf(name, sizeof name, "%s-%016" PRIx64 ".frames", plan.name.c_str(), hashOf(plan.inputs));
    const int file = openCacheFile(folder, name, FrameFile::bytesFor(plan.frame_bytes, plan.count));
    if (file < 0) {
        sayNotKept(plan.name);
        return nullptr;
    }
    auto frames = std::make_unique<FrameFile>(file, plan.frame_bytes, plan.count);
    sayUnlessWhole(*frames, name, plan.count);
    return frames;
}

} // namespace

std::shared_ptr<FrameCache> FrameCache::of(const RenderPlan &plan) {
    static std::mutex mutex;
    // Never destroyed: frames may be drawn while the process ends.
    static auto &caches = *new std::map<std::string, std::shared_ptr<FrameCache>>;
    const auto folder = text(Key::Cache);
    auto known = plan;
    known.inputs += " renderer=" + std::to_string(kRendererVersion) + " count=" + std::to_string(plan.count);
    const std::lock_guard lock(mutex);
    auto &cache = caches[folder + " " + known.name + " " + known.inputs];
    if (!cache)
        cache = std::make_shared<FrameCache>(known, folder);
    return cache;
}

FrameCache::FrameCache(const RenderPlan &plan, const std::string &folder)
    : plan_(plan), shared_(openShared(plan, folder)) {}

FrameCache::~FrameCache() { delete own_; }

const uint8_t *FrameCache::find(size_t index) const {
    if (const uint8_t *frame = shared_ ? shared_->find(index) : nullptr)
        return frame;
    const FrameFile *own = own_;
    return own != nullptr ? own->find(index) : nullptr;
}

bool FrameCache::areDrawn(const std::vector<Place> &places) {
    return std::all_of(places.begin(), places.end(),
                       [](const Place &place) { return place.cache->find(place.index) != nullptr; });
}

bool FrameCache::draw(const std::vector<Place> &places) {
    std::vector<Place> wanted;
    std::copy_if(places.begin(), places.end(), std::back_inserter(wanted),
                 [](const Place &place) { return place.cache->find(place.index) == nullptr; });
    const auto start = std::chrono::steady_clock::now();
    std::atomic<size_t> next{0};
    static auto &turns = *new Turns; // Never destroyed: frames may be drawn while the process ends.
    const auto drawSome = [&] {
        // Linux sets it for this thread alone, which has inherited that of a thread with images.
        setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, getpid()) + kNiceness);
        for (size_t i = next++; i < wanted.size(); i = next++) {
            turns.take();
            wanted[i].cache->drawHere(wanted[i].index);
            turns.leave();
        }
    };
    std::vector<std::thread> threads;
    for (size_t i = 0; i < std::min(kDrawingThreads, wanted.size()); i++)
        threads.emplace_back(drawSome);
    for (auto &thread : threads)
        thread.join();
    const std::chrono::nanoseconds taken = std::chrono::steady_clock::now() - start;
    for (const auto &place : wanted)
        place.cache->drawingNanos_ = taken.count();
    return !wanted.empty();
}

void FrameCache::drawHere(size_t index) {
    const std::lock_guard lock(drawing_);
    if (find(index) != nullptr)
        return;
    // Elsewhere than in the file: drawing sets a pixel more than once, and other processes may show it meanwhile.
    const std::unique_ptr<uint8_t[]> pixels(new uint8_t[plan_.frame_bytes]);
    keep(index, pixels.get(), plan_.draw(index, pixels.get()));
}

void FrameCache::keep(size_t index, const uint8_t *frame, size_t bytes) {
    if (own_ == nullptr) {
        if (shared_ && shared_->write(index, frame, bytes))
            return;
        if (shared_)
            sayNotKept(plan_.name);
        own_ = new FrameFile(FrameFile::kInMemory, plan_.frame_bytes, plan_.count);
    }
    own_.load()->write(index, frame, bytes);
}

const uint8_t *FrameCache::frame(size_t index) {
    if (find(index) == nullptr)
        drawHere(index);
    return find(index);
}

} // namespace ml2sim
