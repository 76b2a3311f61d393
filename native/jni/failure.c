#include "failure.h"

#define CAPTURE_EXCEPTION "dev/ml2sensors/capture/CaptureException$"

static const char *exception_of(ml2s_result result) {
    switch (result) {
    case ML2S_NOT_AVAILABLE:
        return CAPTURE_EXCEPTION "NotAvailable";
    case ML2S_PERMISSION_DENIED:
        return CAPTURE_EXCEPTION "PermissionDenied";
    case ML2S_BUSY:
        return CAPTURE_EXCEPTION "InUse";
    case ML2S_VENDOR_FAILURE:
        return CAPTURE_EXCEPTION "VendorFailure";
    case ML2S_CLOSED:
    case ML2S_WRONG_THREAD:
        return "java/lang/IllegalStateException";
    default:
        return "java/lang/IllegalArgumentException";
    }
}

bool failure_throw(JNIEnv *env, ml2s_result result, const ml2s_error *error) {
    if (result == ML2S_OK || result == ML2S_TIMEOUT) {
        return false;
    }
    jclass exception = (*env)->FindClass(env, exception_of(result));
    if (exception) {
        (*env)->ThrowNew(env, exception,
                         error && error->message[0] ? error->message : "invalid argument of a native call");
    }
    return true;
}
