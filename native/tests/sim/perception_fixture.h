// The simulated headset with its perception system started, and snapshots of it.
#pragma once

#include "headset.h"
#include "ml_perception.h"

/** A snapshot of now or of a time, released at its end. */
class Snapshot {
  public:
    Snapshot() { EXPECT_EQ(MLPerceptionGetSnapshot(&snapshot_), MLResult_Ok); }
    explicit Snapshot(MLTime time) { EXPECT_EQ(MLPerceptionGetPredictedSnapshot(time, &snapshot_), MLResult_Ok); }
    ~Snapshot() { MLPerceptionReleaseSnapshot(snapshot_); }
    Snapshot(const Snapshot &) = delete;
    Snapshot &operator=(const Snapshot &) = delete;

    const MLSnapshot *get() const { return snapshot_; }
    MLResult find(const MLCoordinateFrameUID &frame, MLTransform *out) const {
        return MLSnapshotGetTransform(snapshot_, &frame, out);
    }

  private:
    MLSnapshot *snapshot_ = nullptr;
};

/** A head tracker, a second after it was created. */
class TrackedHeadset : public SimulatedHeadset {
  protected:
    void SetUp() override {
        SimulatedHeadset::SetUp();
        start();
        ASSERT_EQ(MLHeadTrackingCreate(&tracker), MLResult_Ok);
        ml2sim_advance(kSecond);
    }
    void TearDown() override {
        MLHeadTrackingDestroy(tracker);
        MLPerceptionShutdown();
        SimulatedHeadset::TearDown();
    }
    static void start() {
        MLPerceptionSettings settings;
        MLPerceptionInitSettings(&settings);
        ASSERT_EQ(MLPerceptionStartup(&settings), MLResult_Ok);
        const Snapshot first;
    }

    MLHandle tracker = ML_INVALID_HANDLE;
};
