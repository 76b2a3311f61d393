// MLGlobalGetResultString, MLSnapshotGetResultString.
#include <iterator>

#include "ml_unused.h"

const char *MLGlobalGetResultString(MLResult result) {
    constexpr const char *kNames[] = {
        "MLResult_Ok",
        "MLResult_Pending",
        "MLResult_Timeout",
        "MLResult_Locked",
        "MLResult_UnspecifiedFailure",
        "MLResult_InvalidParam",
        "MLResult_AllocFailed",
        "MLResult_PermissionDenied",
        "MLResult_NotImplemented",
        "MLResult_ClientLimitExceeded",
        "MLResult_PoseNotFound",
        "MLResult_IncompatibleSKU",
        "MLResult_PerceptionSystemNotStarted",
        "MLResult_IllegalState",
        "MLResult_LicenseError",
        "MLResult_InvalidTimestamp",
    };
    const bool isKnown = result >= 0 && static_cast<size_t>(result) < std::size(kNames);
    return isKnown ? kNames[result] : "MLResult_Unknown";
}

const char *MLSnapshotGetResultString(MLResult result) {
    return result == MLSnapshotResult_DerivativesNotCalculated ? "MLSnapshotResult_DerivativesNotCalculated"
                                                               : MLGlobalGetResultString(result);
}
