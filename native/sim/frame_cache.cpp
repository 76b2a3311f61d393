#include "frame_cache.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "lazy.h"
#include "settings.h"

namespace ml2sim {
namespace {

/** Part of the inputs of every plan. Increase it when the renderer or the layout of the frames changes. */
constexpr int kRendererVersion = 1;

constexpr int kDrawingThreads = 2;
constexpr size_t kPage = 4096;

/** FNV-1a. */
uint64_t hashOf(const std::string &text) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const unsigned char c : text)
        hash = (hash ^ c) * 0x100000001b3;
    return hash;
}

void mustSucceed(bool isDone, const std::string &what) {
    if (isDone)
        return;
    std::perror(("ml2sim: " + what).c_str());
    std::abort();
}

std::string cachePath(const RenderPlan &plan) {
    const auto folder = text(Key::Cache);
    if (folder.empty())
        return "";
    char file[96];
    std::snprintf(file, sizeof file, "/%s-%016" PRIx64 ".frames", plan.name.c_str(), hashOf(plan.inputs));
    return folder + file;
}

std::atomic<int> waiting{0};

/** Counts the threads that wait for rendered frames. */
struct Waiting {
    Waiting() { waiting++; }
    ~Waiting() { waiting--; }
    Waiting(const Waiting &) = delete;
    Waiting &operator=(const Waiting &) = delete;
};

/** Logs the progress of rendering in steps of 25 %. */
class Progress {
  public:
    explicit Progress(const RenderPlan &plan) : plan_(plan) { log(0); }

    /** Counts a rendered frame. Thread-safe. */
    void step() {
        const size_t done = ++done_;
        if (done * 4 / plan_.count > (done - 1) * 4 / plan_.count)
            log(done * 100 / plan_.count);
    }

  private:
    void log(size_t percent) const {
        std::fprintf(stderr, "ml2sim: drawing %zu frames of %s: %zu %%\n", plan_.count, plan_.name.c_str(), percent);
    }

    const RenderPlan &plan_;
    std::atomic<size_t> done_{0};
};

} // namespace

struct FrameCache::Drawn {
    std::mutex mutex;
    std::vector<bool> is;
};

bool FrameCache::isDrawing() { return waiting > 0; }

std::shared_ptr<FrameCache> FrameCache::of(const RenderPlan &plan) {
    using Entry = Lazy<std::shared_ptr<FrameCache>>;
    static std::mutex mutex;
    static std::map<std::string, std::shared_ptr<Entry>> caches;
    const bool drawsAhead = text(Key::Clock) != "manual";
    auto known = plan;
    known.inputs += " renderer=" + std::to_string(kRendererVersion) + " count=" + std::to_string(plan.count);
    const Waiting here;
    const auto name = (drawsAhead ? "" : "manual ") + known.name + " " + known.inputs;
    std::unique_lock lock(mutex);
    auto &entry = caches[name];
    if (!entry)
        entry = std::make_shared<Entry>([=] { return std::make_shared<FrameCache>(known, drawsAhead); });
    const auto cache = entry;
    lock.unlock();
    return cache->get();
}

FrameCache::FrameCache(const RenderPlan &plan, bool drawsAhead)
    : plan_(plan), stride_((plan.frame_bytes + kPage - 1) / kPage * kPage) {
    const auto path = drawsAhead ? cachePath(plan) : "";
    if (!path.empty() && load(path))
        return;
    const auto partial = path + "." + std::to_string(getpid());
    const int file = path.empty() ? memfd_create(plan.name.c_str(), MFD_CLOEXEC)
                                  : open(partial.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    mustSucceed(file >= 0, "cannot create " + partial);
    const auto bytes = static_cast<off_t>(stride_ * plan.count);
    // On a full disk, drawing into a file with holes would end the process by SIGBUS.
    if (const int failure = drawsAhead ? posix_fallocate(file, 0, bytes) : ftruncate(file, bytes)) {
        if (!path.empty())
            unlink(partial.c_str());
        if (drawsAhead)
            errno = failure;
        mustSucceed(false, std::to_string(bytes) + " bytes for the frames of " + plan.name);
    }
    map(file);
    if (drawsAhead) {
        drawAll();
    } else {
        drawn_ = std::make_unique<Drawn>();
        drawn_->is.resize(plan.count);
    }
    if (!path.empty())
        mustSucceed(rename(partial.c_str(), path.c_str()) == 0, "cannot rename to " + path);
}

FrameCache::~FrameCache() { munmap(frames_, stride_ * plan_.count); }

/** Maps the file and closes it. */
void FrameCache::map(int file) {
    void *memory = mmap(nullptr, stride_ * plan_.count, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    mustSucceed(memory != MAP_FAILED, "cannot map the frames of " + plan_.name);
    close(file);
    frames_ = static_cast<uint8_t *>(memory);
}

bool FrameCache::load(const std::string &path) {
    const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0)
        return false;
    struct stat found {};
    if (fstat(file, &found) != 0 || static_cast<size_t>(found.st_size) != stride_ * plan_.count) {
        close(file);
        return false;
    }
    map(file);
    mustSucceed(mprotect(frames_, stride_ * plan_.count, PROT_READ) == 0, "cannot protect the frames of " + plan_.name);
    return true;
}

void FrameCache::drawAll() {
    Progress progress(plan_);
    std::atomic<size_t> next{0};
    const auto draw = [&] {
        for (size_t i = next++; i < plan_.count; i = next++) {
            plan_.draw(i, frames_ + i * stride_);
            progress.step();
        }
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < kDrawingThreads; i++)
        threads.emplace_back(draw);
    for (auto &thread : threads)
        thread.join();
    mustSucceed(mprotect(frames_, stride_ * plan_.count, PROT_READ) == 0, "cannot protect the frames of " + plan_.name);
}

const uint8_t *FrameCache::frame(size_t index) {
    uint8_t *pixels = frames_ + index * stride_;
    if (!drawn_)
        return pixels;
    const std::lock_guard lock(drawn_->mutex);
    if (!drawn_->is[index])
        plan_.draw(index, pixels);
    drawn_->is[index] = true;
    return pixels;
}

} // namespace ml2sim
