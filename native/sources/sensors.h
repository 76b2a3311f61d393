/** The sensors of ml2s_sensor, and the source that each has with each backend. */
#pragma once

#include "source.h"

enum { SENSOR_BITS = 4 };

struct sensor {
    const char *name; /**< Null: there is no such sensor. */
    uint64_t streams;
    const struct source_ops *sdk, *openxr;
};

/** By ml2s_sensor. */
extern const struct sensor sensors[1 << SENSOR_BITS];

/** Finds the source of a sensor with a backend, for any two numbers. Needs a valid error. */
ml2s_result sensor_find_ops(uint32_t sensor, uint32_t backend, const struct source_ops **ops, ml2s_error *error);

/** Checks that the libraries and symbols of a source exist. */
ml2s_result source_require(const struct source_ops *ops, ml2s_error *error);
