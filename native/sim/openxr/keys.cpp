#include "keys.h"

#include <cstdio>
#include <cstdlib>
#include <iterator>

#include "entry_points.h"
#include "sensor_models.h"

namespace ml2sim::xr {
namespace {

using Row = KeyTable::Row;

/** A key of text that takes one of these words, or is empty. */
Row choice(const char *name, std::vector<std::string> words, const char *meaning) {
    words.insert(words.begin(), "");
    return {name, KeyTable::Kind::Text, 0, 0, 0, meaning, false, std::move(words)};
}

Row whole(const char *name, double standard, double most, const char *meaning) {
    return {name, KeyTable::Kind::Whole, standard, 0, most, meaning};
}

std::vector<std::string> sensorPaths() {
    std::vector<std::string> paths;
    for (const auto &model : sensorModels())
        paths.push_back(model.path);
    return paths;
}

} // namespace

KeyTable declareKeys() {
    const auto sensors = sensorPaths();
    return KeyTable({
        choice("fault.extension.missing", {std::begin(kExtensions), std::end(kExtensions)},
               "an extension that is not offered, by its name"),
        choice("fault.profile.refused",
               {"/interaction_profiles/ext/eye_gaze_interaction", "/interaction_profiles/ml/ml2_controller"},
               "an interaction profile whose bindings are refused"),
        choice("fault.sensor.missing", sensors, "a sensor that is not listed"),
        choice("fault.sensor.taken", sensors, "a sensor whose creation fails"),
        choice("fault.sensor.denied", sensors, "a sensor for which the app has no permission"),
        choice("fault.sensor.stalled", sensors, "a sensor that delivers no frames"),
        choice("fault.sensor.failing", sensors, "a sensor whose calls for data fail"),
        choice("fault.sensor.odd", sensors, "a sensor whose pictures have half the height that was configured"),
        choice("fault.sensor.outside", sensors, "a sensor whose pictures lie outside the buffer given to it"),
        choice("fault.future.fails", {"configure", "start", "stop"}, "the step whose future ends with a failure"),
        whole("fault.future.stuck", 0, 1, "1: futures never become ready"),
        whole("fault.instance.fails", 0, 1, "1: xrCreateInstance fails"),
        whole("fault.session.idle", 0, 1, "1: a session never becomes ready"),
        whole("fault.session.lost", 0, 1, "1: the session is being lost"),
        whole("fault.session.stopping", 0, 1, "1: the session is asked to stop, 0: it may go on"),
        whole("fault.pose.time_invalid", 0, 1, "1: no pose at any past time"),
        whole("fault.gaze.unsupported", 0, 1, "1: the system has no eye gaze"),
        whole("fault.hands.unsupported", 0, 1, "1: the system has no hand tracking"),
        whole("hands.visible", 3, 3, "bits of the hands that are seen: 1 left, 2 right"),
        whole("hands.hidden_joint", 26, 26, "number of a joint that is never tracked; 26: none"),
        whole("future.delay_ms", 2, 60000, "how long an asynchronous call takes"),
        whole("stride.extra_bytes", 0, 65536, "padding of every row of an image"),
        whole("buffer.extra_bytes", 0, 16777216, "what a frame's buffer holds beside its pixels"),
        whole("picture.extra_bytes", 0, 16777216, "padding after a picture, which its size includes"),
    });
}

void resetKeys(KeyTable &keys) {
    const auto problem = keys.reset("ML2SIM_XR");
    if (problem.empty())
        return;
    std::fprintf(stderr, "ML2SIM_XR: %s\n", problem.c_str());
    std::abort();
}

} // namespace ml2sim::xr
