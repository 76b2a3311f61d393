/**
 * The vendor's snapshots, which hold the poses of one instant. Needs the area SDK_PERCEPTION.
 *
 * One thread at a time holds a snapshot; others wait. The vendor does not state that snapshots are thread-safe.
 */
#pragma once

#include "tables.h"

/**
 * Takes the snapshot of an instant. If the vendor has none for it, takes the latest one and logs that. Release it at
 * once with snapshot_release. Needs the area SDK_SNAPSHOT.
 */
ml2s_result snapshot_take(MLTime time, MLSnapshot **out, ml2s_error *error);

/** Releases a snapshot after use. Returns result, or the failure of the release. ML2S_NO_POSE is not a failure. */
ml2s_result snapshot_release(MLSnapshot *snapshot, ml2s_result result, ml2s_error *error);

/** Takes the latest snapshot and releases it. */
MLResult snapshot_touch(void);
