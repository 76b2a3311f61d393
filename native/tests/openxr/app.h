// An app that has an OpenXR instance of its own, through the same loader as the library.
#pragma once

#include <cstdio>
#include <dlfcn.h>
#include <vector>

#include "../../sim/openxr/openxr_headers.h"
#include "openxr_fixture.h"

/** The extensions that all sensors together need. */
inline const std::vector<const char *> kAll = {
    XR_MND_HEADLESS_EXTENSION_NAME,      XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
    XR_EXT_FUTURE_EXTENSION_NAME,        XR_ML_PIXEL_SENSOR_EXTENSION_NAME,
    XR_EXT_HAND_TRACKING_EXTENSION_NAME, XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME};

class App {
  public:
    explicit App(const std::vector<const char *> &extensions) {
        XrInstanceCreateInfo info = {};
        info.type = XR_TYPE_INSTANCE_CREATE_INFO;
        info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
        std::snprintf(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE, "App");
        info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
        info.enabledExtensionNames = extensions.data();
        EXPECT_EQ(call<PFN_xrCreateInstance>("xrCreateInstance")(&info, &instance), XR_SUCCESS);
    }
    ~App() {
        if (session != XR_NULL_HANDLE) {
            EXPECT_EQ(call<PFN_xrDestroySession>("xrDestroySession")(session), XR_SUCCESS);
        }
        EXPECT_EQ(call<PFN_xrDestroyInstance>("xrDestroyInstance")(instance), XR_SUCCESS);
    }
    App(const App &) = delete;
    App &operator=(const App &) = delete;

    void createSession() {
        XrSystemGetInfo system = {XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
        XrSessionCreateInfo info = {XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, 0};
        ASSERT_EQ(call<PFN_xrGetSystem>("xrGetSystem")(instance, &system, &info.systemId), XR_SUCCESS);
        ASSERT_EQ(call<PFN_xrCreateSession>("xrCreateSession")(instance, &info, &session), XR_SUCCESS);
    }

    /** The next event, or XR_TYPE_UNKNOWN. */
    XrEventDataBuffer nextEvent() {
        XrEventDataBuffer event = {};
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
        const auto result = call<PFN_xrPollEvent>("xrPollEvent")(instance, &event);
        return result == XR_SUCCESS ? event : XrEventDataBuffer{};
    }

    ml2s_result lend() {
        auto openxr = sized<ml2s_openxr>();
        openxr.instance = reinterpret_cast<uint64_t>(instance);
        openxr.session = reinterpret_cast<uint64_t>(session);
        openxr.get_instance_proc_addr = symbol("xrGetInstanceProcAddr");
        return ml2s_use_openxr(&openxr, nullptr);
    }

    /** Makes a session and lends it. */
    ml2s_result lendSession() {
        createSession();
        return lend();
    }

    /** A function of the loader's own. */
    template <class Function> Function call(const char *name) { return reinterpret_cast<Function>(symbol(name)); }

    /** A function of the instance, or null. */
    template <class Function> Function find(const char *name) {
        PFN_xrVoidFunction function = nullptr;
        call<PFN_xrGetInstanceProcAddr>("xrGetInstanceProcAddr")(instance, name, &function);
        return reinterpret_cast<Function>(function);
    }

    XrInstance instance = XR_NULL_HANDLE;
    XrSession session = XR_NULL_HANDLE;

  private:
    static void *symbol(const char *name) { return dlsym(dlopen(kLoader, RTLD_NOW), name); }
};
