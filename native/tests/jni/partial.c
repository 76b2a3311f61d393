// A vendor's library of a device that knows MLDepthCameraConnect, and nothing else.
#include <stdint.h>

__attribute__((visibility("default"))) int32_t MLDepthCameraConnect(const void *settings, uint64_t *handle) {
    (void)settings, (void)handle;
    return 4;
}
