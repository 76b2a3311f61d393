// Films with a real clock: drawn ahead, shared, kept in the cache.
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "cameras_fixture.h"

class Films : public SimulatedHeadset {
  protected:
    void SetUp() override {
        SimulatedHeadset::SetUp();
        std::string pattern = testing::TempDir() + "ml2sim_cache_XXXXXX";
        folder = mkdtemp(pattern.data());
        set("clock", "real");
        set("cache", folder.c_str());
    }
    void TearDown() override {
        std::filesystem::remove_all(folder);
        SimulatedHeadset::TearDown();
    }
    /** The pixels of one frame of the eye cameras, got under the real clock. */
    uint8_t pixel() {
        const auto settings = EyePort::settings();
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

TEST_F(Films, AreKeptInTheCacheUnderNamesOfTheirInputs) {
    pixel();
    ASSERT_EQ(files().size(), 4u);
    for (const auto &file : files()) {
        EXPECT_EQ(file.extension(), ".film") << "nothing half written remains";
        EXPECT_EQ(std::filesystem::file_size(file), 60u * 163840u);
    }
    set("seed", "77");
    pixel();
    EXPECT_EQ(files().size(), 8u);
}

TEST_F(Films, AnotherProcessShowsWhatTheCacheHas) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    set("image_noise", "0");
    pixel();
    for (const auto &file : files()) {
        FILE *film = std::fopen(file.c_str(), "r+");
        for (long frame = 0; frame < 60; frame++) {
            std::fseek(film, frame * 163840, SEEK_SET);
            std::fputc(171, film);
        }
        std::fclose(film);
    }
    setenv("ML2SIM", ("loop_seconds=2,image_noise=0,cache=" + folder).c_str(), 1);
    EXPECT_EXIT(
        {
            ml2sim_reset();
            std::exit(pixel());
        },
        testing::ExitedWithCode(171), "");
    unsetenv("ML2SIM");
}
