#include "tables.h"

#include <dlfcn.h>

#include "error.h"
#include "lock.h"

#define LOADED_WITHIN_MS 3000

#define NAME(name, parameters) #name,
#define NAMES(identifier, table, functions, library) static const char *const table##_names[] = {functions(NAME)};
SDK_AREAS(NAMES)

static struct {
    const char *name;
    void *loaded;
} libraries[SDK_LIBRARY_COUNT] = {
    [SDK_LIBPERCEPTION] = {"libperception.magicleap.so", NULL},
    [SDK_LIBINPUT] = {"libinput.magicleap.so", NULL},
};

static const struct area {
    enum sdk_library library;
    uint32_t offset_bytes;
    uint32_t count;
    const char *const *names;
} areas_known[SDK_AREA_COUNT] = {
#define AREA(identifier, table, functions, library)                                                                    \
    [identifier] = {library, offsetof(struct sdk, table), sizeof sdk.table / sizeof(void *), table##_names},
    SDK_AREAS(AREA)};

struct sdk sdk;
static turn_t loading;
static uint32_t loaded;

static ml2s_result load_library(enum sdk_library library, ml2s_error *error) {
    const char *name = libraries[library].name;
    if (!libraries[library].loaded && !(libraries[library].loaded = dlopen(name, RTLD_NOW | RTLD_LOCAL))) {
        return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s (%s)", name, dlerror());
    }
    return ML2S_OK;
}

static ml2s_result load_area(const struct area *area, ml2s_error *error) {
    ml2s_result result = load_library(area->library, error);
    for (uint32_t i = 0; i < area->count && !result; i++) {
        void *address = dlsym(libraries[area->library].loaded, area->names[i]);
        if (!address) {
            return error_set(error, ML2S_NOT_AVAILABLE, 0, "not available: %s/%s", libraries[area->library].name,
                             area->names[i]);
        }
        memcpy((char *)&sdk + area->offset_bytes + i * sizeof address, &address, sizeof address);
    }
    return result;
}

static ml2s_result load(uint32_t areas, ml2s_error *error) {
    for (uint32_t i = 0; i < SDK_AREA_COUNT; i++) {
        if (areas & ~loaded & (1u << i)) {
            ml2s_result result = load_area(&areas_known[i], error);
            if (result) {
                return result;
            }
            loaded |= 1u << i;
        }
    }
    return ML2S_OK;
}

ml2s_result sdk_require(uint32_t areas, ml2s_error *error) {
    uint32_t turn = turn_take(&loading, LOADED_WITHIN_MS);
    if (!turn) {
        return error_set(error, ML2S_VENDOR_FAILURE, 0,
                         "dlopen of a vendor's library has not returned to another sensor");
    }
    ml2s_result result = load(areas, error);
    turn_end(&loading, turn);
    return result;
}
