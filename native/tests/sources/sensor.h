// The common parts of the tests of sources: an opened sensor, slots for a stream, and captures that end by themselves.
#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "../../sdk/ml2s.h"

/** An ml2s structure that knows its size. */
template <class T> T sized() {
    T value = {};
    value.struct_size = sizeof value;
    return value;
}

inline ml2s_settings settingsOf(ml2s_sensor sensor, uint64_t streams, uint64_t second_streams = 0) {
    auto settings = sized<ml2s_settings>();
    settings.sensor = sensor;
    settings.streams = streams;
    settings.second_streams = second_streams;
    settings.rate_hz = 5;
    return settings;
}

/** Slots of a stream, so many of which are free. At the end all must have come back. */
class Slots {
  public:
    explicit Slots(uint32_t stream, uint32_t free = ML2S_MAX_SLOTS) : stream_(stream), held_(ML2S_MAX_SLOTS - free) {
        EXPECT_EQ(ml2s_reserve(stream), ML2S_OK);
        ml2s_memory memory;
        for (auto &slot : held_) {
            EXPECT_EQ(ml2s_take(stream, 1, &slot, &memory), ML2S_OK);
        }
    }
    ~Slots() {
        for (const auto slot : held_) {
            EXPECT_EQ(ml2s_release(stream_, slot), ML2S_OK);
        }
        EXPECT_EQ(ml2s_retire(stream_), ML2S_OK);
        for (uint32_t slot = 0; slot < ML2S_MAX_SLOTS; slot++) {
            EXPECT_EQ(ml2s_release(stream_, slot), ML2S_INVALID_ARGUMENT) << "a slot of " << stream_ << " was leased";
        }
    }
    Slots(const Slots &) = delete;
    Slots &operator=(const Slots &) = delete;

  private:
    uint32_t stream_;
    std::vector<uint32_t> held_;
};

/** Frames of a poll; at their end the slots are given back. */
class Polled : public std::vector<ml2s_frame> {
  public:
    using std::vector<ml2s_frame>::vector;
    ~Polled() {
        for (const auto &frame : *this) {
            if (frame.slot != ML2S_NO_SLOT) {
                EXPECT_EQ(ml2s_release(frame.stream, frame.slot), ML2S_OK);
            }
        }
    }
    Polled(Polled &&) = default;
    Polled &operator=(Polled &&) = delete;
};

/** The frame of a poll that gives one; at its end the slot is given back. */
struct Only : ml2s_frame {
    explicit Only(Polled &&frames)
        : ml2s_frame(frames.empty() ? sized<ml2s_frame>() : frames[0]), polled(std::move(frames)) {
        EXPECT_EQ(polled.size(), 1u);
    }
    const Polled polled;
};

/** A sensor, open while this lives. */
class Sensor {
  public:
    explicit Sensor(const ml2s_settings &settings) { result = ml2s_open(&settings, &handle_, &error); }
    ~Sensor() { ml2s_close(handle_, nullptr); }
    Sensor(const Sensor &) = delete;
    Sensor &operator=(const Sensor &) = delete;

    Polled poll(uint64_t timeout_nanos = 0) {
        Polled frames(4, sized<ml2s_frame>());
        uint32_t count = 0;
        result = ml2s_poll(handle_, timeout_nanos, frames.data(), 4, &count, &error);
        frames.resize(count);
        return frames;
    }
    ml2s_reading pollReading() {
        auto pose = sized<ml2s_reading>();
        uint32_t count = 0;
        result = ml2s_poll_readings(handle_, &pose, 1, &count, &error);
        return pose;
    }
    ml2s_reading colorPose(int64_t device_nanos) {
        auto pose = sized<ml2s_reading>();
        result = ml2s_color_pose(handle_, device_nanos, &pose, &error);
        return pose;
    }
    ml2s_result configure(const ml2s_settings &settings) { return ml2s_configure(handle_, &settings, &error); }
    ml2s_result close() { return ml2s_close(handle_, &error); }
    ml2s_handle handle() const { return handle_; }

    ml2s_result result = ML2S_OK;
    ml2s_error error = sized<ml2s_error>();

  private:
    ml2s_handle handle_ = 0;
};

/** Reads every byte of each frame that is published, the latest only, until the writer is done. */
inline void readAll(uint32_t stream, const std::atomic<bool> &isDone) {
    int64_t last = 0;
    while (!isDone) {
        auto frame = sized<ml2s_frame>();
        if (ml2s_acquire_latest(stream, last, &frame) != ML2S_OK) {
            std::this_thread::yield();
            continue;
        }
        EXPECT_GT(frame.capture_nanos, last);
        last = frame.capture_nanos;
        const auto &plane = frame.planes[ML2S_PLANE_IMAGE];
        EXPECT_GT(plane.size_bytes, 0u);
        volatile uint8_t sum = 0;
        for (uint32_t i = 0; i < plane.size_bytes; i++) {
            sum = static_cast<uint8_t>(sum + frame.data[plane.offset_bytes + i]);
        }
        EXPECT_EQ(ml2s_release(frame.stream, frame.slot), ML2S_OK);
    }
}

/** Checks the frame of a stream whose only frame of a moment was odd. */
inline void expectSkipped(const ml2s_frame &frame) {
    EXPECT_EQ(frame.skipped, 1u);
    EXPECT_EQ(frame.slot, ML2S_NO_SLOT);
    EXPECT_EQ(frame.width, 0u);
    EXPECT_EQ(frame.data, nullptr);
}

/** All frames of the sensor are odd: each is skipped and counted, until the poll fails and says text. */
template <typename Capture> void expectOdd(Sensor &sensor, const std::string &text, Capture capture) {
    for (uint32_t i = 0; i < ML2S_MOST_UNUSABLE_CAPTURES; i++) {
        const auto frames = capture();
        ASSERT_EQ(frames.size(), 1u) << sensor.error.message;
        expectSkipped(frames[0]);
    }
    EXPECT_TRUE(capture().empty());
    EXPECT_EQ(sensor.result, ML2S_VENDOR_FAILURE);
    const std::string message = sensor.error.message;
    EXPECT_EQ(message.find("30 captures in a row without a usable frame, the last: "), 0u) << message;
    EXPECT_NE(message.find(text), std::string::npos) << message;
}

inline void expectOdd(Sensor &sensor, const std::string &text) {
    expectOdd(sensor, text, [&] { return sensor.poll(); });
}
