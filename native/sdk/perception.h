/**
 * The vendor's perception system, which belongs to the process. Thread-safe.
 *
 * It is never shut down here: the vendor says to do so only before the program exits, and another library of the
 * process may rely on it.
 */
#pragma once

#include "tables.h"

/** The function tables that the perception system and its stamps need. */
#define PERCEPTION_AREAS (1u << SDK_PERCEPTION | 1u << SDK_TIME)

/**
 * Starts the perception system unless it runs, and waits up to 2 s for its first snapshot, before which trackers cannot
 * be created. Waits up to 3 s for another thread that does so. Needs the area SDK_PERCEPTION.
 */
ml2s_result perception_start(ml2s_error *error);
