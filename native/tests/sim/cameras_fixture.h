#pragma once

#include "headset.h"
#include "ports.h"

/** A camera, for tests that all three run. What a test still has at its end is released and disconnected. */
template <typename Port> class Cameras : public SimulatedHeadset {
  protected:
    using Data = typename Port::Data;

    void SetUp() override {
        SimulatedHeadset::SetUp();
        ml2sim_advance(kSecond);
    }
    void TearDown() override {
        if (counters().outstanding_gets) {
            EXPECT_EQ(release(), MLResult_Ok);
        }
        if (counters().open_handles) {
            EXPECT_EQ(disconnect(), MLResult_Ok);
        }
        SimulatedHeadset::TearDown();
    }

    MLResult connect() {
        const auto settings = Port::settings();
        return Port::connect(&settings, &handle);
    }
    MLResult get(uint64_t timeout_ms = 0) { return Port::get(handle, timeout_ms, &data); }
    MLResult release() { return Port::release(handle, &data); }
    MLResult disconnect() { return Port::disconnect(handle); }

    void connectAndGet() {
        ASSERT_EQ(connect(), MLResult_Ok);
        ml2sim_advance(100 * kMillisecond);
        ASSERT_EQ(get(), MLResult_Ok);
    }
    void releaseAndDisconnect() {
        EXPECT_EQ(release(), MLResult_Ok);
        EXPECT_EQ(disconnect(), MLResult_Ok);
    }
    void setFault(const char *what, const char *value) {
        set((std::string("fault.") + Port::kName + "." + what).c_str(), value);
    }
    /** Gets the data of a capture under a fault. */
    const Data &dataWith(const char *fault, const char *value) {
        setFault(fault, value);
        connectAndGet();
        return data;
    }
    int64_t frameNumber() const { return data.frames[0].frame_number; }

    MLHandle handle = ML_INVALID_HANDLE;
    Data data = Port::data();
};

using AllPorts = testing::Types<DepthPort, WorldPort, EyePort>;
