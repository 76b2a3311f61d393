// Functions of the vendor's libperception.magicleap.so that libml2sensors does not call, but tests do.
#pragma once

#include "ml_perception.h"

#define ML_UNUSED_FUNCTIONS(F)                                                                                         \
    F(MLPerceptionShutdown, (void))                                                                                    \
    F(MLSnapshotGetTransformWithDerivatives, (const MLSnapshot *snapshot, const MLCoordinateFrameUID *id,              \
                                              MLTransform *out_transform, MLTransformDerivatives *out_derivatives))    \
    F(MLSnapshotGetStaticData, (MLSnapshotStaticData * out_data))                                                      \
    F(MLSnapshotGetPoseInBase, (const MLSnapshot *snapshot, const MLCoordinateFrameUID *base,                          \
                                const MLCoordinateFrameUID *id, MLPose *out_pose))

ML_UNUSED_FUNCTIONS(ML_PROTOTYPE)

enum { MLSnapshotResult_DerivativesNotCalculated = (int32_t)0x87b80000 };

extern "C" __attribute__((visibility("default"))) const char *MLGlobalGetResultString(MLResult result);
extern "C" __attribute__((visibility("default"))) const char *MLSnapshotGetResultString(MLResult result);
