// Answers for OpenXR where it is not built in.
#include "../sdk/error.h"
#include "../sources/source.h"

static ml2s_result require(ml2s_error *error) {
    return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: OpenXR");
}

const struct source_ops ml2s_openxr_ops = {.require = require};

ml2s_result ml2s_use_openxr(const ml2s_openxr *openxr, ml2s_error *error) {
    (void)openxr;
    return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: OpenXR");
}
