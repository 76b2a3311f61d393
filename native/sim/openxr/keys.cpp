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
        whole("fault.map.denied", 0, 1, "1: the app has no permission for maps and their events"),
        whole("fault.map.silent", 0, 1, "1: no event of the map comes"),
        whole("fault.map.fails", 0, 1, "1: requests to localize fail"),
        whole("fault.markers.denied", 0, 1, "1: the app has no permission for markers"),
        whole("fault.markers.unsupported", 0, 1, "1: the system detects no markers"),
        whole("fault.markers.fails", 0, 1, "1: snapshots of markers end with an error"),
        whole("fault.markers.stuck", 0, 1, "1: snapshots of markers never become ready"),
        whole("fault.markers.untracked", 0, 1, "1: markers are found, but their poses are not tracked"),
        whole("fault.markers.false", 0, 1, "1: every second snapshot also finds tag 77, which is not in the room"),
        whole("markers.delay_ms", 20, 60000, "how long a snapshot of markers takes"),
        whole("markers.least_pixels", 20, 1000, "the shortest side of a tag that is still read"),
        whole("markers.estimates_size", 0, 1, "1: the detector needs no size of markers"),
        whole("map.state", 1, 3, "0: not localized, 1: localized, 2: pending, 3: sleeping before a retry"),
        whole("map.confidence", 3, 3, "0: poor, 1: fair, 2: good, 3: excellent"),
        whole("map.errors", 0, 63,
              "bits of a low confidence: 1 unknown, 2 outside, 4 few features, 8 fast, 16 dark, 32 head pose"),
        whole("map.count", 2, 3, "how many maps there are; the third has the name of the first"),
        whole("map.delay_ms", 20, 60000, "how long a request to localize is pending"),
        whole("map.moved_mm", 0, 10000, "by how much the origin of the map has moved, without an event"),
        whole("fault.calibration.silent", 0, 1, "1: no event of fit and calibration comes"),
        whole("fault.calibration.refused", 0, 1, "1: enabling events of fit and calibration fails"),
        whole("headset.fit", 2, 3, "0: unknown, 1: not worn, 2: good, 3: bad"),
        whole("eyes.calibration", 3, 3, "0: unknown, 1: none, 2: coarse, 3: fine"),
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
