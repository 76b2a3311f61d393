#include "loader.h"

#include <dlfcn.h>
#include <string.h>

#include "../sdk/error.h"

/** The layout of XrLoaderInitInfoAndroidKHR and XrInstanceCreateInfoAndroidKHR, whose declarations need jni.h. */
struct android_info {
    XrStructureType type;
    const void *next;
    void *java_vm;
    void *activity;
};

enum { MAX_OFFERED = 256 };
static XrExtensionProperties offered[MAX_OFFERED];
static uint32_t offered_count;

bool loader_offers(const char *extension) {
    for (uint32_t i = 0; i < offered_count; i++) {
        if (!strcmp(offered[i].extensionName, extension)) {
            return true;
        }
    }
    return false;
}

static ml2s_result find(PFN_xrGetInstanceProcAddr get_proc, const char *name, PFN_xrVoidFunction *function,
                        ml2s_error *error) {
    XrResult result = get_proc(XR_NULL_HANDLE, name, function);
    return XR_SUCCEEDED(result) ? ML2S_OK
                                : error_set(error, ML2S_NOT_AVAILABLE, result, "not available: OpenXR loader/%s", name);
}

static ml2s_result initialize(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr get_proc, ml2s_error *error) {
    PFN_xrInitializeLoaderKHR initialize_loader;
    ml2s_result result = find(get_proc, "xrInitializeLoaderKHR", (PFN_xrVoidFunction *)&initialize_loader, error);
    if (result) {
        return result;
    }
    struct android_info info = {XR_TYPE_LOADER_INIT_INFO_ANDROID_KHR, NULL, openxr->java_vm, openxr->activity};
    return xr_result_of(initialize_loader((const XrLoaderInitInfoBaseHeaderKHR *)&info), "xrInitializeLoaderKHR",
                        error);
}

ml2s_result loader_find(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr *get_proc, ml2s_error *error) {
    void *library = dlopen(openxr->loader_path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s (%s)", openxr->loader_path, dlerror());
    }
    *get_proc = (PFN_xrGetInstanceProcAddr)dlsym(library, "xrGetInstanceProcAddr");
    return *get_proc ? ML2S_OK
                     : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s/xrGetInstanceProcAddr",
                                 openxr->loader_path);
}

ml2s_result loader_open(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr *get_proc, ml2s_error *error) {
    ml2s_result result = loader_find(openxr, get_proc, error);
    return result || !openxr->java_vm ? result : initialize(openxr, *get_proc, error);
}

static ml2s_result list_offered(PFN_xrGetInstanceProcAddr get_proc, ml2s_error *error) {
    PFN_xrEnumerateInstanceExtensionProperties enumerate;
    ml2s_result result =
        find(get_proc, "xrEnumerateInstanceExtensionProperties", (PFN_xrVoidFunction *)&enumerate, error);
    if (result) {
        return result;
    }
    for (uint32_t i = 0; i < MAX_OFFERED; i++) {
        offered[i] = (XrExtensionProperties){.type = XR_TYPE_EXTENSION_PROPERTIES};
    }
    XrResult enumerated = enumerate(NULL, MAX_OFFERED, &offered_count, offered);
    return enumerated == XR_ERROR_RUNTIME_UNAVAILABLE
               ? error_set(error, ML2S_NOT_AVAILABLE, enumerated, "not available: OpenXR runtime")
               : xr_result_of(enumerated, "xrEnumerateInstanceExtensionProperties", error);
}

/** Lists the extensions to enable: those that the library uses, and that the runtime offers with what they need. */
static uint32_t choose(bool is_android, const char **chosen) {
#define EXTENSION(identifier, table, functions, extension, needs) {extension, needs},
    static const struct {
        const char *name, *needs;
    } used[] = {{XR_MND_HEADLESS_EXTENSION_NAME, NULL}, XR_AREAS(EXTENSION)};
    uint32_t count = 0;
    for (uint32_t i = 0; i < sizeof used / sizeof *used; i++) {
        if (loader_offers(used[i].name) && (!used[i].needs || loader_offers(used[i].needs))) {
            chosen[count++] = used[i].name;
        }
    }
    if (is_android) {
        chosen[count++] = "XR_KHR_android_create_instance";
    }
    return count;
}

ml2s_result loader_create_instance(const ml2s_openxr *openxr, PFN_xrGetInstanceProcAddr get_proc, ml2s_error *error) {
    PFN_xrCreateInstance create;
    ml2s_result result = find(get_proc, "xrCreateInstance", (PFN_xrVoidFunction *)&create, error);
    if (result || (result = list_offered(get_proc, error))) {
        return result;
    }
    if (!loader_offers(XR_MND_HEADLESS_EXTENSION_NAME)) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: " XR_MND_HEADLESS_EXTENSION_NAME);
    }
    const char *extensions[XR_AREA_COUNT + 2];
    struct android_info android = {XR_TYPE_INSTANCE_CREATE_INFO_ANDROID_KHR, NULL, openxr->java_vm, openxr->activity};
    XrInstanceCreateInfo info = {
        .type = XR_TYPE_INSTANCE_CREATE_INFO,
        .next = openxr->java_vm ? &android : NULL,
        .applicationInfo = {.applicationName = "ML2 Sensors", .apiVersion = XR_MAKE_VERSION(1, 0, 0)},
        .enabledExtensionCount = choose(openxr->java_vm, extensions),
        .enabledExtensionNames = extensions,
    };
    XrResult created = create(&info, &xr.instance);
    if (created == XR_ERROR_LIMIT_REACHED) {
        return error_set(error, ML2S_BUSY, created,
                         "this app has an OpenXR instance already: give it to ml2s_use_openxr");
    }
    return xr_result_of(created, "xrCreateInstance", error);
}
