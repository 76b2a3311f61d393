#include "layout.h"

#include <stddef.h>

#include "../sdk/ml2s.h"

jintArray layout_ints(JNIEnv *env, const jint *values, jsize count) {
    jintArray array = (*env)->NewIntArray(env, count);
    if (array) {
        (*env)->SetIntArrayRegion(env, array, 0, count, values);
    }
    return array;
}

#define FRAME(field) offsetof(ml2s_frame, field)
jintArray layout_frame(JNIEnv *env, jobject) {
    static const jint values[] = {
        sizeof(ml2s_frame),
        FRAME(stream),
        FRAME(slot),
        FRAME(has),
        FRAME(frame_number),
        FRAME(capture_nanos),
        FRAME(planes),
        sizeof(ml2s_plane),
        offsetof(ml2s_plane, offset_bytes),
        offsetof(ml2s_plane, size_bytes),
        offsetof(ml2s_plane, stride_bytes),
        FRAME(width),
        FRAME(height),
        FRAME(rotation),
        FRAME(position),
        FRAME(lens),
        FRAME(focal_length),
        FRAME(principal_point),
        FRAME(distortion),
        FRAME(exposure_nanos),
        FRAME(analog_gain),
        FRAME(digital_gain),
        FRAME(illumination),
        FRAME(skipped),
        FRAME(head_rotation),
        FRAME(head_position),
    };
    return layout_ints(env, values, sizeof values / sizeof *values);
}

#define READING(field) offsetof(ml2s_reading, field)
jintArray layout_reading(JNIEnv *env, jobject) {
    static const jint values[] = {
        sizeof(ml2s_reading), READING(stream), READING(capture_nanos), READING(rotation), READING(position),
        READING(is_tracked),  READING(events), READING(values),        READING(id),       READING(name),
    };
    return layout_ints(env, values, sizeof values / sizeof *values);
}

#define SETTINGS(field) offsetof(ml2s_settings, field)
jintArray layout_settings(JNIEnv *env, jobject) {
    static const jint values[] = {
        sizeof(ml2s_settings),   SETTINGS(sensor),          SETTINGS(backend),           SETTINGS(wants),
        SETTINGS(streams),       SETTINGS(second_streams),  SETTINGS(rate_hz),           SETTINGS(width),
        SETTINGS(height),        SETTINGS(marker_type),     SETTINGS(marker_dictionary), SETTINGS(marker_profile),
        SETTINGS(marker_camera), SETTINGS(marker_length_m), SETTINGS(map_confidence),    SETTINGS(map),
    };
    return layout_ints(env, values, sizeof values / sizeof *values);
}
