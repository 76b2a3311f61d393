// Frame caches: rendered when first read, shared by processes, and kept in the cache folder.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "frame_cache.h"

using ml2sim::FrameCache;
using ml2sim::RenderPlan;
namespace fs = std::filesystem;

constexpr size_t kFrames = 6;
constexpr size_t kBytes = 3 * 4096 + 5;
constexpr size_t kStride = 4 * 4096;

/** The expected value of each byte of a frame. */
uint8_t byteOf(size_t index) { return static_cast<uint8_t>(10 + index); }

/** Draws like the renderers: first other pixels, then those that last. Counts what it draws. */
struct Drawing {
    std::atomic<int> frames{0};

    RenderPlan plan(const std::string &inputs = "") {
        return {"test", inputs, kBytes, kFrames, [this](size_t index, uint8_t *frame) {
                    frames++;
                    std::memset(frame, 255, kBytes);
                    std::memset(frame, byteOf(index), kBytes);
                    return kBytes;
                }};
    }
};

bool isWhole(const uint8_t *frame, size_t index) {
    for (size_t i = 0; i < kBytes; i++)
        if (frame[i] != byteOf(index))
            return false;
    return true;
}

class FrameCaches : public testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = testing::TempDir() + "ml2sim_cache_XXXXXX";
        folder = mkdtemp(pattern.data());
    }
    void TearDown() override { fs::remove_all(folder); }
    std::vector<fs::path> files() const {
        std::vector<fs::path> out;
        for (const auto &entry : fs::directory_iterator(folder))
            out.push_back(entry.path());
        return out;
    }
    /** Runs a child process and returns its pid. */
    template <class Work> static pid_t start(Work work) {
        const pid_t child = fork();
        if (child == 0) {
            work();
            _exit(0);
        }
        return child;
    }
    static int statusOf(pid_t child) {
        int status = 0;
        EXPECT_EQ(waitpid(child, &status, 0), child);
        return status;
    }
    /** Makes a file of frames that was used so many hours ago. */
    fs::path oldFile(const std::string &name, uintmax_t bytes, int hours) const {
        const auto path = fs::path(folder) / name;
        std::ofstream(path).close();
        fs::resize_file(path, bytes);
        fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(hours));
        return path;
    }

    std::string folder;
    Drawing drawing;
};

TEST_F(FrameCaches, AFrameIsDrawnWhenItIsFirstReadAndOnlyThen) {
    FrameCache cache(drawing.plan(), folder);
    EXPECT_EQ(drawing.frames, 0);
    EXPECT_TRUE(isWhole(cache.frame(3), 3));
    EXPECT_TRUE(isWhole(cache.frame(3), 3));
    EXPECT_EQ(drawing.frames, 1);
    EXPECT_FALSE(FrameCache::draw({{&cache, 3}}));
    EXPECT_TRUE(FrameCache::draw({{&cache, 2}, {&cache, 3}, {&cache, 4}, {&cache, 5}}));
    EXPECT_EQ(drawing.frames, 4);
}

TEST_F(FrameCaches, TwoFramesAreDrawnAtOnceOfAllCamerasTogether) {
    constexpr auto kDrawn = std::chrono::milliseconds(5);
    std::mutex mutex;
    std::condition_variable begun;
    int atOnce = 0, most = 0;
    const auto draw = [&](size_t index, uint8_t *frame) {
        std::unique_lock lock(mutex);
        most = std::max(most, ++atOnce);
        begun.notify_all();
        begun.wait_for(lock, kDrawn, [&] { return atOnce > 2; }); // which is not to come
        atOnce--;
        std::memset(frame, byteOf(index), kBytes);
        return kBytes;
    };
    std::deque<FrameCache> caches;
    for (const auto *name : {"one", "another", "a third"})
        caches.emplace_back(RenderPlan{name, "", kBytes, kFrames, draw}, folder);
    std::vector<std::thread> cameras;
    for (auto &cache : caches)
        cameras.emplace_back([&] { FrameCache::draw({{&cache, 0}, {&cache, 1}}); });
    for (auto &camera : cameras)
        camera.join();
    EXPECT_EQ(most, 2);
    for (const auto &cache : caches)
        EXPECT_GE(cache.drawingNanos(), 2 * std::chrono::nanoseconds(kDrawn).count()) << "two frames of one cache";
}

TEST_F(FrameCaches, TheFoldersFilesAreNamedByTheirInputs) {
    for (const auto *inputs : {"a", "b", "b"})
        FrameCache(drawing.plan(inputs), folder).frame(0);
    EXPECT_EQ(drawing.frames, 2);
    EXPECT_EQ(files().size(), 2u);
    for (const auto &file : files())
        EXPECT_EQ(file.extension(), ".frames");
}

TEST_F(FrameCaches, AFileThatLacksFramesSaysHowManyItHas) {
    testing::internal::CaptureStderr();
    FrameCache first(drawing.plan(), folder);
    for (size_t i = 1; i < kFrames; i++)
        first.frame(i);
    FrameCache second(drawing.plan(), folder);
    second.frame(0);
    FrameCache whole(drawing.plan(), folder);
    const auto name = files().at(0).filename().string();
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "ml2sim: " + name + ": 0 of 6 frames are rendered\nml2sim: " + name + ": 5 of 6 frames are rendered\n");
}

TEST_F(FrameCaches, OnlyDrawnFramesTakeSpaceOnTheDisk) {
    FrameCache(drawing.plan(), folder).frame(5);
    struct stat found {};
    ASSERT_EQ(stat(files().at(0).c_str(), &found), 0);
    EXPECT_LT(size_t(found.st_blocks) * 512, 2 * kStride);
}

TEST_F(FrameCaches, AProcessShowsWhatAnotherDrew) {
    ASSERT_EQ(statusOf(start([&] { FrameCache(drawing.plan(), folder).frame(2); })), 0);
    FrameCache cache(drawing.plan(), folder);
    EXPECT_TRUE(isWhole(cache.frame(2), 2));
    EXPECT_EQ(drawing.frames, 0);
    EXPECT_TRUE(isWhole(cache.frame(1), 1));
    EXPECT_EQ(drawing.frames, 1);
}

TEST_F(FrameCaches, AFrameThatAnotherProcessDrawsMeanwhileIsNotDrawnAgain) {
    FrameCache cache(drawing.plan(), folder);
    ASSERT_EQ(statusOf(start([&] { FrameCache(drawing.plan(), folder).frame(2); })), 0);
    EXPECT_TRUE(isWhole(cache.frame(2), 2));
    EXPECT_EQ(drawing.frames, 0);
}

TEST_F(FrameCaches, ProcessesAndThreadsThatDrawAtOnceNeverShowAnUnfinishedFrame) {
    const auto readAll = [&] {
        for (int round = 0; round < 40; round++) {
            Drawing own;
            FrameCache cache(own.plan(std::to_string(round)), folder);
            std::vector<std::thread> threads;
            std::atomic<bool> areWhole{true};
            for (int n = 0; n < 2; n++)
                threads.emplace_back([&] {
                    for (size_t index = 0; index < kFrames; index++)
                        areWhole = areWhole && isWhole(cache.frame(index), index);
                });
            for (auto &thread : threads)
                thread.join();
            if (!areWhole)
                _exit(1);
        }
    };
    std::vector<pid_t> children;
    for (int n = 0; n < 3; n++)
        children.push_back(start(readAll));
    for (const pid_t child : children)
        EXPECT_EQ(statusOf(child), 0);
}

TEST_F(FrameCaches, AProcessThatIsKilledLeavesNoUnfinishedFrame) {
    for (int round = 0; round < 20; round++) {
        int drawn[2];
        ASSERT_EQ(pipe(drawn), 0);
        const pid_t child = start([&] {
            for (size_t n = 0;; n++) {
                FrameCache cache(drawing.plan(std::to_string(n)), folder);
                for (size_t index = 0; index < kFrames; index++)
                    cache.frame(index);
                if (write(drawn[1], "x", 1) != 1)
                    _exit(1);
            }
        });
        char x;
        EXPECT_EQ(read(drawn[0], &x, 1), 1);
        kill(child, SIGKILL);
        EXPECT_TRUE(WIFSIGNALED(statusOf(child)));
        close(drawn[0]);
        close(drawn[1]);
        const size_t count = files().size();
        for (size_t n = 0; n < count; n++) {
            FrameCache cache(drawing.plan(std::to_string(n)), folder);
            for (size_t index = 0; index < kFrames; index++)
                ASSERT_TRUE(isWhole(cache.frame(index), index)) << "file " << n << ", frame " << index;
        }
        EXPECT_EQ(files().size(), count) << "it left no other files";
        for (const auto &file : files())
            fs::remove(file);
    }
}

TEST_F(FrameCaches, AFullDiskIsSaidOnceAndFramesAreKeptInMemory) {
    FrameCache cache(drawing.plan(), folder);
    EXPECT_TRUE(isWhole(cache.frame(0), 0));
    const auto before = signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{kStride + kBytes / 2, limit.rlim_max}; // within the second frame
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    testing::internal::CaptureStderr();
    const uint8_t *second = cache.frame(1), *third = cache.frame(2);
    const auto said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(said, "ml2sim: cannot keep the frames of test in the cache: File too large; this process keeps them in "
                    "memory\n");
    EXPECT_TRUE(isWhole(second, 1) && isWhole(third, 2) && isWhole(cache.frame(0), 0));
    EXPECT_EQ(drawing.frames, 3);
    EXPECT_EQ(cache.frame(1), second);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    signal(SIGXFSZ, before);
    FrameCache later(drawing.plan(), folder);
    EXPECT_TRUE(isWhole(later.frame(0), 0) && isWhole(later.frame(1), 1));
    EXPECT_EQ(drawing.frames, 4) << "the second frame, whose beginning alone is on the disk";
}

TEST_F(FrameCaches, AFolderThatIsNotThereIsSaidAndFramesAreKeptInMemory) {
    testing::internal::CaptureStderr();
    FrameCache cache(drawing.plan(), folder + "/none");
    const auto said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("No such file or directory"), std::string::npos) << said;
    EXPECT_TRUE(isWhole(cache.frame(1), 1));
}

TEST_F(FrameCaches, AFileOfAnotherSizeIsDrawnAnew) {
    FrameCache(drawing.plan(), folder).frame(0);
    fs::resize_file(files().at(0), 4096);
    EXPECT_TRUE(isWhole(FrameCache(drawing.plan(), folder).frame(0), 0));
    EXPECT_EQ(drawing.frames, 2);
    EXPECT_GT(fs::file_size(files().at(0)), kFrames * kStride);
}

TEST_F(FrameCaches, TheFolderHasAtMost4GiBAndLosesWhatWasNotUsedForLongest) {
    constexpr uintmax_t kGiB = uintmax_t{1} << 30;
    const auto oldest = oldFile("a-1.frames", kGiB, 4), old = oldFile("b-1.frames.1234", kGiB, 3);
    const auto recent = oldFile("c-1.frames", kGiB, 2), newest = oldFile("d-1.frames", kGiB, 1);
    const auto other = oldFile("notes.txt", 5 * kGiB, 9);
    FrameCache(drawing.plan(), folder).frame(0);
    EXPECT_FALSE(fs::exists(oldest));
    EXPECT_TRUE(fs::exists(old) && fs::exists(recent) && fs::exists(newest) && fs::exists(other));
    auto large = drawing.plan("large");
    large.frame_bytes = kGiB / 2;
    FrameCache(large, folder).frame(0);
    EXPECT_FALSE(fs::exists(old) || fs::exists(recent) || fs::exists(newest)) << "6 frames are 3 GiB";
    EXPECT_EQ(files().size(), 3u);
}

TEST_F(FrameCaches, AFileThatIsInUseGoesOnWhenItIsRemoved) {
    FrameCache cache(drawing.plan(), folder);
    fs::remove(files().at(0));
    EXPECT_TRUE(isWhole(cache.frame(0), 0));
}

TEST_F(FrameCaches, AFileAboveTheLimitIsNotKept) {
    auto plan = drawing.plan();
    plan.frame_bytes = size_t{1} << 30;
    FrameCache cache(plan, folder);
    EXPECT_TRUE(isWhole(cache.frame(5), 5));
    EXPECT_TRUE(files().empty());
}
