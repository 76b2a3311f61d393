#include "runtime.h"

#include <stdatomic.h>
#include <string.h>

#include "../sdk/error.h"
#include "../sdk/lock.h"
#include "actions.h"
#include "loader.h"
#include "session.h"

#define NAME(name) #name,
#define NAMES(identifier, table, functions, extension, needs)                                                          \
    static const char *const table##_names[] = {functions(NAME)};
XR_AREAS(NAMES)

static const struct area {
    const char *extension;
    size_t offset_bytes;
    size_t count;
    const char *const *names;
} areas_known[XR_AREA_COUNT] = {
#define AREA(identifier, table, functions, extension, needs)                                                           \
    [identifier] = {extension, offsetof(struct xr, table), sizeof xr.table / sizeof(void *), table##_names},
    XR_AREAS(AREA)};

#define CLOSED_WITHIN_NANOS INT64_C(1000000000)

/** As long as the app's thread may wait for one that looks for the loader. */
#define FREE_WITHIN_MS 100

static turn_t changing;
static _Atomic uint32_t users;

/** True while there is an instance, which may have no users: a thread that is to end it may not get its turn. */
static bool is_begun;

static ml2s_openxr chosen;
static char chosen_path[512];
static atomic_bool is_app_session_ending;

/** Takes the turn if no sensor uses OpenXR; else returns 0. */
static uint32_t take_free_turn(void) {
    uint32_t turn = turn_take(&changing, FREE_WITHIN_MS);
    if (turn && (atomic_load(&users) || is_begun)) {
        turn_end(&changing, turn);
        return 0;
    }
    return turn;
}

/** Clears the choice of ml2s_use_openxr. Returns false if a sensor still uses it. */
static bool clear_choice(void) {
    uint32_t turn = take_free_turn();
    if (turn) {
        chosen = (ml2s_openxr){0};
        turn_end(&changing, turn);
    }
    return turn;
}

static ml2s_result end_app_session(ml2s_error *error) {
    atomic_store(&is_app_session_ending, true);
    for (int64_t until = ml2s_now() + CLOSED_WITHIN_NANOS; ml2s_now() < until; sleep_millisecond()) {
        if (clear_choice()) {
            return ML2S_OK;
        }
    }
    return error_set(error, ML2S_BUSY, 0, "ml2s_use_openxr: sensors of OpenXR were not closed within 1 s");
}

static ml2s_result require_app_session(ml2s_error *error) {
    return atomic_load(&is_app_session_ending)
               ? error_set(error, ML2S_VENDOR_FAILURE, XR_ERROR_SESSION_LOST, "the app is ending its OpenXR session")
               : ML2S_OK;
}

ml2s_result ml2s_use_openxr(const ml2s_openxr *openxr, ml2s_error *error) {
    if (!openxr) {
        return end_app_session(error);
    }
    if (openxr->struct_size < sizeof *openxr) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0, "ml2s_openxr.struct_size: expected at least %u",
                         (unsigned)sizeof *openxr);
    }
    bool is_standalone = openxr->loader_path;
    bool is_borrowed = openxr->instance && openxr->session && openxr->get_instance_proc_addr;
    if (is_standalone == is_borrowed || (is_standalone && strlen(openxr->loader_path) >= sizeof chosen_path)) {
        return error_set(error, ML2S_INVALID_ARGUMENT, 0,
                         "ml2s_openxr: expected either loader_path or instance, session and get_instance_proc_addr");
    }
    uint32_t turn = take_free_turn();
    if (!turn) {
        return error_set(error, ML2S_BUSY, 0, "ml2s_use_openxr: close all sensors of OpenXR first");
    }
    chosen = *openxr;
    atomic_store(&is_app_session_ending, false);
    if (is_standalone) {
        memcpy(chosen_path, openxr->loader_path, strlen(openxr->loader_path) + 1);
        chosen.loader_path = chosen_path;
    }
    turn_end(&changing, turn);
    return ML2S_OK;
}

static bool find_area(const struct area *area, PFN_xrGetInstanceProcAddr get_proc) {
    for (size_t i = 0; i < area->count; i++) {
        PFN_xrVoidFunction function;
        if (XR_FAILED(get_proc(xr.instance, area->names[i], &function)) || !function) {
            return false;
        }
        memcpy((char *)&xr + area->offset_bytes + i * sizeof function, &function, sizeof function);
    }
    return true;
}

static void find_areas(PFN_xrGetInstanceProcAddr get_proc) {
    for (uint32_t i = 0; i < XR_AREA_COUNT; i++) {
        bool is_enabled = xr.is_borrowed || i == XR_CORE || loader_offers(areas_known[i].extension);
        if (is_enabled && find_area(&areas_known[i], get_proc)) {
            xr.areas |= XR_AREA_BIT(i);
        }
    }
}

static ml2s_result require(uint32_t areas, ml2s_error *error) {
    for (uint32_t i = 0; i < XR_AREA_COUNT; i++) {
        if (areas & ~xr.areas & XR_AREA_BIT(i)) {
            return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s%s", areas_known[i].extension,
                             xr.is_borrowed ? " (not enabled by the app)" : "");
        }
    }
    return ML2S_OK;
}

static ml2s_result create_world(ml2s_error *error) {
    XrReferenceSpaceCreateInfo info = {
        XR_TYPE_REFERENCE_SPACE_CREATE_INFO, NULL, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
    return XR_CALL(error, core, xrCreateReferenceSpace, xr.session, &info, &xr.world);
}

static ml2s_result require_choice(ml2s_error *error) {
    return chosen.struct_size
               ? ML2S_OK
               : error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: OpenXR (ml2s_use_openxr was not called)");
}

ml2s_result xr_require(ml2s_error *error) {
    PFN_xrGetInstanceProcAddr get_proc;
    uint32_t turn = xr_take_turn(&changing, error);
    if (!turn) {
        return ML2S_VENDOR_FAILURE;
    }
    ml2s_result result = require_choice(error);
    if (!result && chosen.loader_path) {
        result = loader_find(&chosen, &get_proc, error);
    }
    turn_end(&changing, turn);
    return result;
}

/** Takes the app's instance, or creates one, and fills the function tables. */
static ml2s_result get_instance(ml2s_error *error) {
    PFN_xrGetInstanceProcAddr get_proc = (PFN_xrGetInstanceProcAddr)chosen.get_instance_proc_addr;
    xr = (struct xr){.is_borrowed = !chosen.loader_path};
    is_begun = true;
    if (xr.is_borrowed) {
        xr.instance = (XrInstance)(uintptr_t)chosen.instance;
        xr.session = (XrSession)(uintptr_t)chosen.session;
    } else {
        ml2s_result result = loader_open(&chosen, &get_proc, error);
        if (result || (result = loader_create_instance(&chosen, get_proc, error))) {
            return result;
        }
    }
    find_areas(get_proc);
    return require(XR_AREA_BIT(XR_CORE) | XR_AREA_BIT(XR_TIME), error);
}

static ml2s_result begin(ml2s_error *error) {
    ml2s_result result = require_choice(error);
    if (result || (result = get_instance(error))) {
        return result;
    }
    XrSystemGetInfo info = {XR_TYPE_SYSTEM_GET_INFO, NULL, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    result = XR_CALL(error, core, xrGetSystem, xr.instance, &info, &xr.system);
    if (!result && !xr.is_borrowed) {
        result = session_create(error);
    }
    return result ? result : create_world(error);
}

/** Destroys the objects that begin has created, also after a partial failure. Returns the first failure. */
static ml2s_result end(ml2s_error *error) {
    ml2s_result first = ML2S_OK;
    if (xr.world) {
        first = XR_CALL(error, core, xrDestroySpace, xr.world);
    }
    if (!xr.is_borrowed && xr.session) {
        ml2s_result result = actions_destroy(first ? NULL : error);
        first = first ? first : result;
        result = session_destroy(first ? NULL : error);
        first = first ? first : result;
    }
    if (!xr.is_borrowed && xr.core.xrDestroyInstance) {
        ml2s_result result = XR_CALL(first ? NULL : error, core, xrDestroyInstance, xr.instance);
        first = first ? first : result;
    }
    is_begun = false;
    return first;
}

static ml2s_result acquire(uint32_t areas, ml2s_error *error) {
    uint32_t turn = xr_take_turn(&changing, error);
    if (!turn) {
        return ML2S_VENDOR_FAILURE;
    }
    ml2s_result result = is_begun ? require_app_session(error) : begin(error);
    if (!result) {
        result = require(areas, error);
    }
    if (!result) {
        atomic_fetch_add(&users, 1);
    } else if (is_begun && !atomic_load(&users)) {
        end(NULL);
    }
    turn_end(&changing, turn);
    return result;
}

/** The last user ends the instance; if the runtime does not return to another thread, the next last one does. */
static ml2s_result release(ml2s_error *error) {
    if (atomic_fetch_sub(&users, 1) > 1) {
        return ML2S_OK;
    }
    uint32_t turn = xr_take_turn(&changing, error);
    if (!turn) {
        return ML2S_VENDOR_FAILURE;
    }
    ml2s_result result = is_begun && !atomic_load(&users) ? end(error) : ML2S_OK;
    turn_end(&changing, turn);
    return result;
}

ml2s_result xr_begin(uint32_t areas, ml2s_result (*make)(const ml2s_settings *settings, ml2s_error *error),
                     const ml2s_settings *settings, ml2s_error *error) {
    ml2s_result result = acquire(areas, error);
    if (!result && (result = make(settings, error))) {
        release(NULL);
    }
    return result;
}

ml2s_result xr_end(ml2s_result result, ml2s_error *error) {
    ml2s_result released = release(result ? NULL : error);
    return result ? result : released;
}

ml2s_result xr_handle_events(ml2s_error *error) {
    return xr.is_borrowed ? require_app_session(error) : session_handle_events(error);
}
