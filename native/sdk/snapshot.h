/**
 * The vendor's snapshots, which hold the poses of one instant. Needs the area SDK_PERCEPTION.
 *
 * One thread at a time holds a snapshot, since the vendor does not state that snapshots are thread-safe. Others wait
 * for up to 1 s. A thread that the vendor has not returned to by then no longer counts.
 */
#pragma once

#include "tables.h"

/** A snapshot, and the turn of the thread that holds it. */
struct snapshot {
    MLSnapshot *of;
    uint32_t turn;
};

/**
 * Takes the snapshot of an instant. If the vendor has none for it, takes the latest one and logs that. Release it at
 * once with snapshot_release. Needs the area SDK_SNAPSHOT.
 */
ml2s_result snapshot_take(MLTime time, struct snapshot *out, ml2s_error *error);

/** Releases a snapshot after use. Returns result, or the failure of the release. ML2S_NO_POSE is not a failure. */
ml2s_result snapshot_release(struct snapshot snapshot, ml2s_result result, ml2s_error *error);

/** Takes the latest snapshot and releases it. */
MLResult snapshot_touch(void);
