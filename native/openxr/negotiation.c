#include "negotiation.h"

#include "../sdk/error.h"
#include "future.h"

enum { MAX_CAPABILITIES = 16, MAX_VALUES = 32, MAX_CONFIGS = 4, OFFER_LENGTH = 120 };

/** The values selected so far. Each range of capabilities depends on them. */
struct negotiation {
    XrPixelSensorML sensor;
    const struct pixel_mode *mode;
    XrPixelSensorCapabilityML capabilities[MAX_CAPABILITIES];
    uint32_t capability_count;
    XrPixelSensorConfigUint32ML numbers[MAX_CONFIGS];
    XrPixelSensorConfigExtent2DiML extent;
    const XrPixelSensorConfigBaseHeaderML *configs[MAX_CONFIGS];
    uint32_t config_count;
};

static ml2s_result list_capabilities(struct negotiation *n, ml2s_error *error) {
    for (uint32_t i = 0; i < MAX_CAPABILITIES; i++) {
        n->capabilities[i] = (XrPixelSensorCapabilityML){.type = XR_TYPE_PIXEL_SENSOR_CAPABILITY_ML};
    }
    return XR_CALL(error, pixel, xrEnumeratePixelSensorCapabilitiesML, n->sensor, n->mode->device_stream,
                   MAX_CAPABILITIES, &n->capability_count, n->capabilities);
}

static const XrPixelSensorCapabilityML *find(const struct negotiation *n, XrPixelSensorCapabilityTypeML type) {
    for (uint32_t i = 0; i < n->capability_count; i++) {
        if (n->capabilities[i].capabilityType == type) {
            return &n->capabilities[i];
        }
    }
    return NULL;
}

static ml2s_result query(const struct negotiation *n, XrPixelSensorCapabilityTypeML type, void *range,
                         ml2s_error *error) {
    XrPixelSensorCapabilityQueryInfoML info = {XR_TYPE_PIXEL_SENSOR_CAPABILITY_QUERY_INFO_ML, NULL,
                                               n->mode->device_stream, type};
    return XR_CALL(error, pixel, xrQueryPixelSensorCapabilityRangeML, n->sensor, &info, n->config_count, n->configs,
                   (XrPixelSensorRangeBaseHeaderML *)range);
}

static void append(char *text, uint32_t *length, uint32_t number, char before) {
    char digits[10];
    uint32_t count = 0;
    do {
        digits[count++] = (char)('0' + number % 10);
    } while (number /= 10);
    if (*length + count + 2 > OFFER_LENGTH) {
        return;
    }
    text[(*length)++] = before;
    while (count) {
        text[(*length)++] = digits[--count];
    }
    text[*length] = 0;
}

static ml2s_result refuse(const struct negotiation *n, const char *what, const char *wanted, const char *offered,
                          ml2s_error *error) {
    return error_set(error, ML2S_INVALID_ARGUMENT, 0, "%s stream %u: no %s%s, offered:%s", n->mode->path,
                     n->mode->device_stream, what, wanted, *offered ? offered : " none");
}

static ml2s_result refuse_type(const struct negotiation *n, const char *what,
                               const XrPixelSensorCapabilityML *capability, ml2s_error *error) {
    return error_set(error, ML2S_VENDOR_FAILURE, 0, "%s stream %u: %s has unknown range %u of type %u", n->mode->path,
                     n->mode->device_stream, what, capability->rangeType, capability->dataType);
}

static ml2s_result add_number(struct negotiation *n, XrPixelSensorCapabilityTypeML type, uint32_t value) {
    XrPixelSensorConfigUint32ML *config = &n->numbers[n->config_count];
    *config =
        (XrPixelSensorConfigUint32ML){XR_TYPE_PIXEL_SENSOR_CONFIG_UINT32_ML, NULL, n->mode->device_stream, type, value};
    n->configs[n->config_count++] = (const XrPixelSensorConfigBaseHeaderML *)config;
    return ML2S_OK;
}

static ml2s_result choose_from_range(struct negotiation *n, XrPixelSensorCapabilityTypeML type, const char *what,
                                     uint32_t value, ml2s_error *error) {
    XrPixelSensorRangeContinuousUint32ML range = {.type = XR_TYPE_PIXEL_SENSOR_RANGE_CONTINUOUS_UINT32_ML};
    ml2s_result result = query(n, type, &range, error);
    if (result) {
        return result;
    }
    if (range.valid && range.min <= value && value <= range.max) {
        return add_number(n, type, value);
    }
    char wanted[OFFER_LENGTH] = "", offered[OFFER_LENGTH] = "";
    uint32_t length = 0;
    append(wanted, &length, value, ' ');
    length = 0;
    append(offered, &length, range.min, ' ');
    append(offered, &length, range.max, '-');
    return refuse(n, what, wanted, range.valid ? offered : "", error);
}

static ml2s_result choose_from_list(struct negotiation *n, XrPixelSensorCapabilityTypeML type, const char *what,
                                    uint32_t value, ml2s_error *error) {
    uint32_t values[MAX_VALUES];
    XrPixelSensorRangeDiscreteUint32ML range = {
        .type = XR_TYPE_PIXEL_SENSOR_RANGE_DISCRETE_UINT32_ML, .capacityInput = MAX_VALUES, .values = values};
    ml2s_result result = query(n, type, &range, error);
    char wanted[OFFER_LENGTH] = "", offered[OFFER_LENGTH] = "";
    uint32_t length = 0;
    for (uint32_t i = 0; !result && range.valid && i < range.countOutput; i++) {
        if (values[i] == value) {
            return add_number(n, type, value);
        }
        append(offered, &length, values[i], ' ');
    }
    length = 0;
    append(wanted, &length, value, ' ');
    return result ? result : refuse(n, what, wanted, offered, error);
}

/** Selects a value. A stream that lacks the capability offers no choice, which fails only if is_mandatory. */
static ml2s_result choose_number(struct negotiation *n, XrPixelSensorCapabilityTypeML type, const char *what,
                                 uint32_t value, bool is_mandatory, ml2s_error *error) {
    const XrPixelSensorCapabilityML *capability = find(n, type);
    if (!capability) {
        return is_mandatory ? refuse(n, what, "", "", error) : ML2S_OK;
    }
    if (capability->dataType != XR_PIXEL_SENSOR_UINT32_ML ||
        capability->rangeType == XR_PIXEL_SENSOR_RANGE_BOOLEAN_ML) {
        return refuse_type(n, what, capability, error);
    }
    return capability->rangeType == XR_PIXEL_SENSOR_RANGE_CONTINUOUS_ML ? choose_from_range(n, type, what, value, error)
                                                                        : choose_from_list(n, type, what, value, error);
}

static ml2s_result choose_resolution(struct negotiation *n, ml2s_error *error) {
    const XrPixelSensorCapabilityML *capability = find(n, XR_PIXEL_SENSOR_RESOLUTION_ML);
    if (!capability) {
        return refuse(n, "resolution", "", "", error);
    }
    if (capability->dataType != XR_PIXEL_SENSOR_EXTENT_2DI_ML ||
        capability->rangeType != XR_PIXEL_SENSOR_RANGE_DISCRETE_ML) {
        return refuse_type(n, "resolution", capability, error);
    }
    XrExtent2Di values[MAX_VALUES];
    XrPixelSensorRangeDiscreteExtent2DiML range = {
        .type = XR_TYPE_PIXEL_SENSOR_RANGE_DISCRETE_EXTENT_2DI_ML, .capacityInput = MAX_VALUES, .values = values};
    ml2s_result result = query(n, XR_PIXEL_SENSOR_RESOLUTION_ML, &range, error);
    char wanted[OFFER_LENGTH] = "", offered[OFFER_LENGTH] = "";
    uint32_t length = 0;
    for (uint32_t i = 0; !result && range.valid && i < range.countOutput; i++) {
        if ((uint32_t)values[i].width == n->mode->width && (uint32_t)values[i].height == n->mode->height) {
            n->extent =
                (XrPixelSensorConfigExtent2DiML){XR_TYPE_PIXEL_SENSOR_CONFIG_EXTENT_2DI_ML, NULL,
                                                 n->mode->device_stream, XR_PIXEL_SENSOR_RESOLUTION_ML, values[i]};
            n->configs[n->config_count++] = (const XrPixelSensorConfigBaseHeaderML *)&n->extent;
            return ML2S_OK;
        }
        append(offered, &length, (uint32_t)values[i].width, ' ');
        append(offered, &length, (uint32_t)values[i].height, 'x');
    }
    length = 0;
    append(wanted, &length, n->mode->width, ' ');
    append(wanted, &length, n->mode->height, 'x');
    return result ? result : refuse(n, "resolution", wanted, offered, error);
}

static ml2s_result configure(const struct negotiation *n, ml2s_error *error) {
    XrPixelSensorConfigInfoML info = {.type = XR_TYPE_PIXEL_SENSOR_CONFIG_INFO_ML,
                                      .streamCount = 1,
                                      .streams = &n->mode->device_stream,
                                      .configCount = n->config_count,
                                      .configs = n->configs};
    XrPixelSensorConfigureCompletionML completion = {.type = XR_TYPE_PIXEL_SENSOR_CONFIGURE_COMPLETION_ML};
    return XR_COMPLETE(error, xrConfigurePixelSensor, n->sensor, &info, &completion, true);
}

ml2s_result negotiate(XrPixelSensorML sensor, const struct pixel_mode *mode, ml2s_error *error) {
    struct negotiation n = {.sensor = sensor, .mode = mode};
    ml2s_result result = list_capabilities(&n, error);
    if (!result) {
        result = choose_number(&n, XR_PIXEL_SENSOR_UPDATE_RATE_ML, "update rate", mode->rate_hz, true, error);
    }
    if (!result) {
        result = choose_resolution(&n, error);
    }
    if (!result) {
        result = choose_number(&n, XR_PIXEL_SENSOR_FORMAT_ML, "format", mode->format, true, error);
    }
    if (!result) {
        result = choose_number(&n, XR_PIXEL_SENSOR_MIXED_REALITY_ML, "reality", mode->reality, false, error);
    }
    return result ? result : configure(&n, error);
}
