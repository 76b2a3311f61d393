// The interface between loader and runtime, and xrGetInstanceProcAddr.
#include <cstring>

#include "entry_points.h"
#include "ml2sim.h"
#include "runtime.h"

namespace ml2sim::xr {
namespace {

struct Known {
    const char *name;
    const char *extension;
    PFN_xrVoidFunction function;
};
constexpr bool isForAll(const char *name) {
    for (const char *other : {"xrEnumerateInstanceExtensionProperties", "xrCreateInstance", "xrGetInstanceProcAddr"})
        if (std::string_view(name) == other)
            return true;
    return false;
}
#define XR_KNOWN(name, extension) {#name, extension, reinterpret_cast<PFN_xrVoidFunction>(name)},
const Known known[] = {XR_ENTRY_POINTS(XR_KNOWN)};

} // namespace

XrResult xrGetInstanceProcAddr(XrInstance instance, const char *name, PFN_xrVoidFunction *function) {
    return entry([&](auto &) {
        requireNonNull(function, "function") = nullptr;
        if (instance != XR_NULL_HANDLE)
            find<Instance>(instance, "instance");
        for (const auto &candidate : known) {
            if (std::strcmp(candidate.name, name) != 0)
                continue;
            if (instance == XR_NULL_HANDLE && !isForAll(name))
                return XR_ERROR_HANDLE_INVALID;
            // The loader queries all functions that it knows, which is no misuse.
            if (*candidate.extension != '\0' && runtime().extensions.count(candidate.extension) == 0)
                return XR_ERROR_FUNCTION_UNSUPPORTED;
            *function = candidate.function;
            return XR_SUCCESS;
        }
        return XR_ERROR_FUNCTION_UNSUPPORTED;
    });
}

} // namespace ml2sim::xr

namespace {

/** The structures that loader and runtime exchange. Debian's packages lack Khronos' header for them. */
struct LoaderInfo {
    uint32_t structType; ///< 1
    uint32_t structVersion;
    size_t structSize;
    uint32_t minInterfaceVersion, maxInterfaceVersion;
    XrVersion minApiVersion, maxApiVersion;
};
struct RuntimeRequest {
    uint32_t structType; ///< 3
    uint32_t structVersion;
    size_t structSize;
    uint32_t runtimeInterfaceVersion;
    XrVersion runtimeApiVersion;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};
constexpr uint32_t kLoaderInfo = 1;
constexpr uint32_t kRuntimeRequest = 3;
constexpr uint32_t kVersion = 1;

} // namespace

extern "C" ML2SIM_API XrResult xrNegotiateLoaderRuntimeInterface(const LoaderInfo *loader, RuntimeRequest *request) {
    if (loader == nullptr || loader->structType != kLoaderInfo || loader->structVersion != kVersion ||
        loader->structSize != sizeof *loader || request == nullptr || request->structType != kRuntimeRequest ||
        request->structVersion != kVersion || request->structSize != sizeof *request ||
        loader->minInterfaceVersion > kVersion || loader->maxInterfaceVersion < kVersion)
        return XR_ERROR_INITIALIZATION_FAILED;
    request->runtimeInterfaceVersion = kVersion;
    request->runtimeApiVersion = XR_MAKE_VERSION(1, 0, 20);
    request->getInstanceProcAddr = ml2sim::xr::xrGetInstanceProcAddr;
    return XR_SUCCESS;
}
