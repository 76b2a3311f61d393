/** Results of the vendor's calls, in words. */
#pragma once

#include "ml2s.h"
#include "ml_types.h"

/** Ok and Timeout say nothing; others set error to text such as "MLDepthCameraConnect: InvalidParam (5)". */
ml2s_result result_of(MLResult code, const char *call, ml2s_error *error);
