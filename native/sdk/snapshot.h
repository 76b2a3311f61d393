/**
 * Snapshots of where things are. Needs the area SDK_PERCEPTION.
 *
 * One thread at a time has a snapshot, and others wait: the vendor does not say that several threads may.
 */
#pragma once

#include "perception.h"

/**
 * A snapshot of an instant, or the latest one where the vendor has none of that instant, which is logged. Needs the
 * area SDK_SNAPSHOT. To be given back with snapshot_release, at once.
 */
ml2s_result snapshot_take(MLTime time, MLSnapshot **out, ml2s_error *error);

/** Gives back a snapshot that was used with result; answers the first failure, and a pose that it has not is none. */
ml2s_result snapshot_release(MLSnapshot *snapshot, ml2s_result result, ml2s_error *error);

/** Takes the latest one and gives it back. */
MLResult snapshot_touch(void);
