#include "result.h"

#include "error.h"

static const char *const names[] = {
    [MLResult_Ok] = "Ok",
    [MLResult_Pending] = "Pending",
    [MLResult_Timeout] = "Timeout",
    [MLResult_Locked] = "Locked",
    [MLResult_UnspecifiedFailure] = "UnspecifiedFailure",
    [MLResult_InvalidParam] = "InvalidParam",
    [MLResult_AllocFailed] = "AllocFailed",
    [MLResult_PermissionDenied] = "PermissionDenied",
    [MLResult_NotImplemented] = "NotImplemented",
    [MLResult_ClientLimitExceeded] = "ClientLimitExceeded",
    [MLResult_PoseNotFound] = "PoseNotFound",
    [MLResult_IncompatibleSKU] = "IncompatibleSKU",
    [MLResult_PerceptionSystemNotStarted] = "PerceptionSystemNotStarted",
    [MLResult_IllegalState] = "IllegalState",
    [MLResult_LicenseError] = "LicenseError",
    [MLResult_InvalidTimestamp] = "InvalidTimestamp",
};

static ml2s_result ml2s_result_of(MLResult code) {
    switch (code) {
    case MLResult_Ok:
        return ML2S_OK;
    case MLResult_Timeout:
        return ML2S_TIMEOUT;
    case MLResult_PermissionDenied:
        return ML2S_PERMISSION_DENIED;
    case MLResult_PoseNotFound:
    case MLResult_InvalidTimestamp:
        return ML2S_NO_POSE;
    default:
        return ML2S_VENDOR_FAILURE;
    }
}

ml2s_result result_of(MLResult code, const char *call, ml2s_error *error) {
    ml2s_result result = ml2s_result_of(code);
    if (result == ML2S_OK || result == ML2S_TIMEOUT) {
        return result;
    }
    if (code < 0 || code >= (MLResult)(sizeof names / sizeof *names)) {
        return error_set(error, result, code, "%s: MLResult 0x%x", call, (uint32_t)code);
    }
    return error_set(error, result, code, "%s: %s (%d)", call, names[code], code);
}
