// The simulated headset under a clock of the test's own, with its books checked at the end.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

#include "ml2sim.h"

constexpr int64_t kMillisecond = 1000000;
constexpr int64_t kSecond = 1000000000;

inline void set(const char *key, const char *value) {
    const char *problem = ml2sim_set(key, value);
    ASSERT_EQ(problem, nullptr) << problem;
}

inline ml2sim_book books() {
    ml2sim_book book;
    ml2sim_books(&book);
    return book;
}

class SimulatedHeadset : public testing::Test {
  protected:
    void SetUp() override {
        ml2sim_reset();
        set("clock", "manual");
        set("loop_seconds", "2");
    }

    /** A test that misuses on purpose says which misuses it expects, and how many. */
    void expectMisuse(ml2sim_misuse kind, uint32_t count = 1) { expected_[kind] += count; }

    void TearDown() override {
        const auto book = books();
        for (int kind = 0; kind < ML2SIM_MISUSE_COUNT; kind++)
            EXPECT_EQ(book.misuses[kind], expected_[kind]) << "kind " << kind << ": " << book.last_misuse;
        EXPECT_EQ(book.open_handles, 0u);
        EXPECT_EQ(book.outstanding_gets, 0u);
        EXPECT_EQ(book.outstanding_snapshots, 0u);
        EXPECT_EQ(book.outstanding_capability_lists, 0u);
    }

  private:
    uint32_t expected_[ML2SIM_MISUSE_COUNT] = {};
};
