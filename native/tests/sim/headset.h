// The simulated headset with a manual clock; its counters are checked at the end of each test.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <string>

#include "ml2sim.h"

constexpr int64_t kMillisecond = 1000000;
constexpr int64_t kSecond = 1000000000;

inline void set(const std::string &key, const char *value) {
    const char *problem = ml2sim_set(key.c_str(), value);
    ASSERT_EQ(problem, nullptr) << problem;
}

inline ml2sim_counters counters() {
    ml2sim_counters counters;
    ml2sim_get_counters(&counters);
    return counters;
}

/** A structure of the vendor's as its initialiser leaves it. */
template <class T> T initialised(void (*initialise)(T *)) {
    T out;
    initialise(&out);
    return out;
}

class SimulatedHeadset : public testing::Test {
  protected:
    void SetUp() override {
        ml2sim_reset();
        set("clock", "manual");
        set("loop_seconds", "2");
        set("noise", "0"); // tests compare with the truth
    }

    /** A test that misuses on purpose says which misuses it expects, and how many. */
    void expectMisuse(ml2sim_misuse kind, uint32_t count = 1) { expected_[kind] += count; }

    void TearDown() override {
        const auto values = counters();
        for (int kind = 0; kind < ML2SIM_MISUSE_COUNT; kind++)
            EXPECT_EQ(values.misuses[kind], expected_[kind]) << "kind " << kind << ": " << values.last_misuse;
        EXPECT_EQ(values.open_handles, 0u);
        EXPECT_EQ(values.outstanding_gets, 0u);
        EXPECT_EQ(values.outstanding_snapshots, 0u);
        EXPECT_EQ(values.outstanding_capability_lists, 0u);
    }

  private:
    uint32_t expected_[ML2SIM_MISUSE_COUNT] = {};
};
