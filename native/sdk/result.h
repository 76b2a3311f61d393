/** Conversion of the vendor's result codes. */
#pragma once

#include "ml2s.h"
#include "ml_types.h"

/** Converts a result code. A failure sets error to a text such as "MLDepthCameraConnect: InvalidParam (5)". */
ml2s_result result_of(MLResult code, const char *call, ml2s_error *error);
