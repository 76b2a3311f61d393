/**
 * Base types and result codes of the vendor's C interface, declared from published facts for interoperability.
 *
 * C linkage, natural alignment, 32-bit enums. Each ml_*.h file lists the functions that this library calls as
 * F(name, parameters). Prototypes, function tables and symbol names are generated from that list. Every function
 * returns an MLResult.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
#define ML_ASSERT(condition, text) static_assert(condition, text)
#define ML_PROTOTYPE(name, parameters) extern "C" __attribute__((visibility("default"))) MLResult name parameters;
#else
#define ML_ASSERT(condition, text) _Static_assert(condition, text)
#define ML_PROTOTYPE(name, parameters) __attribute__((visibility("default"))) MLResult name parameters;
#endif
#define ML_SIZE(type, bytes) ML_ASSERT(sizeof(type) == (bytes), "size of " #type)
#define ML_OFFSET(type, member, bytes) ML_ASSERT(offsetof(type, member) == (bytes), #type "." #member)

typedef int32_t MLResult;
typedef uint64_t MLHandle;
/** Nanoseconds of the device's clock; see ml_time.h. */
typedef int64_t MLTime;

#define ML_INVALID_HANDLE UINT64_MAX

enum {
    MLResult_Ok = 0,
    MLResult_Pending = 1,
    MLResult_Timeout = 2,
    MLResult_Locked = 3,
    MLResult_UnspecifiedFailure = 4,
    MLResult_InvalidParam = 5,
    MLResult_AllocFailed = 6,
    MLResult_PermissionDenied = 7,
    MLResult_NotImplemented = 8,
    MLResult_ClientLimitExceeded = 9,
    MLResult_PoseNotFound = 10,
    MLResult_IncompatibleSKU = 11,
    MLResult_PerceptionSystemNotStarted = 12,
    MLResult_IllegalState = 13,
    MLResult_LicenseError = 14,
    MLResult_InvalidTimestamp = 15,
};

typedef struct MLVec2f {
    float x, y;
} MLVec2f;

typedef struct MLVec3f {
    float x, y, z;
} MLVec3f;

typedef struct MLQuaternionf {
    float x, y, z, w;
} MLQuaternionf;

/** Axes: x right, y up, z backward. Metres. */
typedef struct MLTransform {
    MLQuaternionf rotation;
    MLVec3f position;
} MLTransform;

typedef struct MLCoordinateFrameUID {
    uint64_t data[2];
} MLCoordinateFrameUID;

ML_SIZE(MLVec2f, 8);
ML_SIZE(MLVec3f, 12);
ML_SIZE(MLQuaternionf, 16);
ML_SIZE(MLTransform, 28);
ML_OFFSET(MLTransform, position, 16);
ML_SIZE(MLCoordinateFrameUID, 16);
