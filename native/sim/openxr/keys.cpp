#include "keys.h"

#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace ml2sim::xr {

Keys::Keys() {
    const auto text = [this](const char *key, const char *meaning) { declare(key, "", meaning, false); };
    const auto count = [this](const char *key, const char *value, const char *meaning) {
        declare(key, value, meaning, true);
    };
    text("fault.extension.missing", "an extension that is not offered, by its name");
    text("fault.sensor.missing", "a sensor that is not listed, such as /pixelsensor/eye/nasal/left");
    text("fault.sensor.taken", "a sensor whose creation fails");
    text("fault.sensor.denied", "a sensor for which the app has no permission");
    text("fault.sensor.stalled", "a sensor that delivers no frames");
    text("fault.sensor.failing", "a sensor whose calls for data fail");
    text("fault.sensor.odd", "a sensor whose pictures have half the height that was configured");
    text("fault.sensor.outside", "a sensor whose pictures lie outside the buffer given to it");
    text("fault.future.fails", "the step whose future ends with a failure: configure, start or stop");
    count("fault.future.stuck", "0", "1: futures never become ready");
    count("fault.instance.fails", "0", "1: xrCreateInstance fails");
    count("fault.session.idle", "0", "1: a session never becomes ready");
    count("fault.session.lost", "0", "1: the session is being lost");
    count("fault.session.stopping", "0", "1: the session is asked to stop, 0: it may go on");
    count("fault.pose.time_invalid", "0", "1: no pose at any past time");
    count("fault.gaze.unsupported", "0", "1: the system has no eye gaze");
    count("fault.hands.unsupported", "0", "1: the system has no hand tracking");
    count("hands.visible", "3", "bits of the hands that are seen: 1 left, 2 right");
    count("hands.hidden_joint", "26", "number of a joint that is never tracked; 26: none");
    count("future.delay_ms", "2", "how long an asynchronous call takes");
    count("stride.extra_bytes", "0", "padding of every row of an image");
    count("buffer.extra_bytes", "0", "what a frame's buffer holds beside its pixels");
    count("picture.extra_bytes", "0", "padding after a picture, which its size includes");
    readEnvironment();
}

void Keys::declare(const char *key, const char *value, const char *meaning, bool isNumber) {
    keys_[key] = {value, value, meaning, isNumber};
}

std::string Keys::set(const std::string &key, const std::string &value) {
    const auto found = keys_.find(key);
    if (found == keys_.end()) {
        return "no key " + key + "; there are:\n" + describe();
    }
    if (found->second.isNumber && (value.empty() || value.find_first_not_of("0123456789") != std::string::npos)) {
        return key + ": expected a number, found " + value;
    }
    found->second.value = value;
    return {};
}

void Keys::reset() {
    for (auto &[name, key] : keys_) {
        key.value = key.initial;
    }
    readEnvironment();
}

std::string Keys::describe() const {
    std::string lines;
    for (const auto &[name, key] : keys_) {
        lines += name + " = " + key.value + "  " + key.meaning + "\n";
    }
    return lines;
}

const std::string &Keys::text(const std::string &key) const { return keys_.at(key).value; }

int64_t Keys::number(const std::string &key) const { return std::stoll(keys_.at(key).value); }

void Keys::readEnvironment() {
    const char *given = std::getenv("ML2SIM_XR");
    std::istringstream items(given == nullptr ? "" : given);
    for (std::string item; std::getline(items, item, ',');) {
        const size_t equals = item.find('=');
        const std::string wrong = equals == std::string::npos ? "expected key=value, found " + item
                                                              : set(item.substr(0, equals), item.substr(equals + 1));
        if (!wrong.empty()) {
            std::fprintf(stderr, "ML2SIM_XR: %s\n", wrong.c_str());
            std::abort();
        }
    }
}

} // namespace ml2sim::xr
