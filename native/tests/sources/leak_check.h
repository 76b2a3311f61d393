// The fixture of tests on the simulated headset.
#pragma once

#include "ml2sim.h"
#include "sensor.h"

/** A test on a new simulated headset. Its end checks for leaks and misuses. */
class LeakCheck : public testing::Test {
  protected:
    void SetUp() override { ml2sim_reset(); }
    void TearDown() override {
        ml2sim_counters counters;
        ml2sim_get_counters(&counters);
        EXPECT_STREQ(counters.last_misuse, "");
        EXPECT_EQ(counters.open_handles + counters.outstanding_snapshots, 0u);
    }

    static void set(const char *key, const char *value) { ASSERT_EQ(ml2sim_set(key, value), nullptr); }
};
