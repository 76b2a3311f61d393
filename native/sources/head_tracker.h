/** A head tracker of the vendor's, with the perception system that it needs. */
#pragma once

#include "../sdk/perception.h"

/** What opening one needs of the vendor's library. */
#define HEAD_TRACKER_AREAS (1u << SDK_HEAD | 1u << SDK_PERCEPTION)

/** On failure *tracker is ML_INVALID_HANDLE. */
ml2s_result head_tracker_open(MLHandle *tracker, ml2s_error *error);

/**
 * After the head's was opened for another tracker that needs it: result is how creating that went. A failure empties
 * both.
 */
ml2s_result head_tracker_accompanies(ml2s_result result, MLHandle *other, MLHandle *tracker);

/** *tracker is ML_INVALID_HANDLE afterwards; one that already is, is left. */
ml2s_result head_tracker_close(MLHandle *tracker, ml2s_error *error);
