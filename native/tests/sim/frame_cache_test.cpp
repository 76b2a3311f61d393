// Frame caches with a real clock: rendered in advance, shared, and kept in the cache folder.
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "cameras_fixture.h"

constexpr uint32_t kFrames = 2; // of STILL_HEAD, at its start and its end

class FrameCaches : public SimulatedHeadset {
  protected:
    void SetUp() override {
        SimulatedHeadset::SetUp();
        std::string pattern = testing::TempDir() + "ml2sim_cache_XXXXXX";
        folder = mkdtemp(pattern.data());
        set("trajectory", STILL_HEAD);
        set("clock", "real");
        set("cache", folder.c_str());
    }
    void TearDown() override {
        std::filesystem::remove_all(folder);
        SimulatedHeadset::TearDown();
    }
    /** A pixel of a frame of one eye camera, got under the real clock. */
    uint8_t pixel() {
        auto settings = EyePort::settings();
        settings.cameras = MLEyeCameraIdentifier_LeftNasal;
        MLHandle handle = 0;
        auto data = EyePort::data();
        EXPECT_EQ(MLEyeCameraConnect(&settings, &handle), MLResult_Ok);
        EXPECT_EQ(MLEyeCameraGetLatestCameraData(handle, 5000, &data), MLResult_Ok);
        const uint8_t out = data.frames[0].frame_buffer.data[0];
        MLEyeCameraReleaseCameraData(handle, &data);
        MLEyeCameraDisconnect(handle);
        return out;
    }
    std::vector<std::filesystem::path> files() {
        std::vector<std::filesystem::path> out;
        for (const auto &entry : std::filesystem::directory_iterator(folder))
            out.push_back(entry.path());
        return out;
    }

    std::string folder;
};

TEST_F(FrameCaches, AreKeptInTheCacheUnderNamesOfTheirInputs) {
    pixel();
    ASSERT_EQ(files().size(), 1u);
    for (const auto &file : files()) {
        EXPECT_EQ(file.extension(), ".frames") << "nothing half written remains";
        EXPECT_EQ(std::filesystem::file_size(file), kFrames * 163840u);
    }
    set("seed", "77");
    pixel();
    EXPECT_EQ(files().size(), 2u);
}

TEST_F(FrameCaches, AProcessShowsWhatAnotherLeftInTheCache) {
    const auto drawInAnotherProcess = [this] {
        pixel();
        std::exit(files().size() == 1 ? 0 : 1);
    };
    set("seed", "79");
    EXPECT_EXIT(drawInAnotherProcess(), testing::ExitedWithCode(0), "drawing");
    for (const auto &file : files()) {
        FILE *frames = std::fopen(file.c_str(), "r+");
        for (long frame = 0; frame < long{kFrames}; frame++) {
            std::fseek(frames, frame * 163840, SEEK_SET);
            std::fputc(171, frames);
        }
        std::fclose(frames);
    }
    EXPECT_EQ(pixel(), 171);
}

TEST_F(FrameCaches, AFileOfAnotherSizeIsDrawnAnew) {
    const auto drawInAnotherProcess = [this] {
        pixel();
        std::exit(0);
    };
    set("seed", "78");
    EXPECT_EXIT(drawInAnotherProcess(), testing::ExitedWithCode(0), "drawing");
    for (const auto &file : files())
        std::filesystem::resize_file(file, 163840);
    pixel();
    for (const auto &file : files())
        EXPECT_EQ(std::filesystem::file_size(file), kFrames * 163840u);
}
