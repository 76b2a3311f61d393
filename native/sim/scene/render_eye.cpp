#include "canvas.h"
#include "hash.h"
#include "noise.h"

#include <algorithm>
#include <cmath>

namespace ml2sim {
namespace {

constexpr float kTurn = 6.2831853f;
constexpr float kIris_px = 74;
constexpr int kLamps = 6;

/** 0 outside of an edge, 1 inside, blended over `soft` pixels. */
float inside(float distance, float soft) { return std::clamp(0.5f - distance / soft, 0.0f, 1.0f); }

float mixed(float a, float b, float t) { return a + t * (b - a); }

/** The eye at one instant, in pixels, as its camera sees it: the nose is on the side that `nasal` points to. */
struct Eye {
    float nasal;        ///< 1 right, -1 left
    float squeeze;      ///< The factor by which circles are narrower, seen from aside.
    Spot iris;          ///< Centre.
    float pupil_px;     ///< Radius.
    float openness;     ///< 0 closed to 1 open.
    Spot lamps[kLamps]; ///< Reflections of the lamps about the display: they follow the gaze only in part.
};

Eye eyeAt(EyeCamera camera, float phase) {
    const bool isLeft = camera == EyeCamera::LeftTemple || camera == EyeCamera::LeftNasal;
    const bool isNasal = camera == EyeCamera::LeftNasal || camera == EyeCamera::RightNasal;
    Eye eye;
    eye.nasal = isLeft ? -1.0f : 1.0f; // Seen from the headset, the wearer's left eye is on the right of the nose.
    eye.squeeze = isNasal ? 0.86f : 0.92f;
    const float aside = eye.nasal * (isNasal ? -14.0f : 18.0f);
    eye.iris = {200 + aside + 46 * std::cos(kTurn * phase), 202 + 24 * std::sin(2 * kTurn * phase)};
    eye.pupil_px = kIris_px * (0.40f + 0.05f * std::sin(3 * kTurn * phase));
    const float sinceBlink = std::abs(phase - 0.62f) / 0.045f;
    eye.openness = std::clamp(sinceBlink * sinceBlink, 0.03f, 1.0f);
    for (int n = 0; n < kLamps; n++) {
        const float angle = kTurn * (n + 0.5f) / kLamps;
        eye.lamps[n] = {mixed(200, eye.iris.x, 0.55f) + 36 * std::cos(angle),
                        mixed(204, eye.iris.y, 0.55f) + 30 * std::sin(angle)};
    }
    return eye;
}

/** From the middle of the lids, up and down, pixels; both meet in the corners of the eye. */
float lidHeight(const Eye &eye, float x, float height) {
    const float s = (x - 200 + 12 * eye.nasal) / 176;
    return height * std::max(0.0f, 1 - s * s) + 10 * eye.nasal * s;
}

float upperLid(const Eye &eye, float x) { return 222 - lidHeight(eye, x, mixed(-28, 112, eye.openness)); }
float lowerLid(const Eye &eye, float x) {
    return 222 + lidHeight(eye, x, mixed(34, 72, eye.openness)) - 20 * eye.nasal * (x - 200) / 176;
}

/** Value noise of cells one unit wide. */
float grain(float x, float y) {
    const auto knot = [](float a, float b) {
        return float(mix(uint64_t(int64_t(a)) << 32 ^ uint64_t(int64_t(b))) >> 40) * 0x1p-24f;
    };
    const float column = std::floor(x), row = std::floor(y), fx = x - column, fy = y - row;
    const float above = mixed(knot(column, row), knot(column + 1, row), fx);
    return mixed(above, mixed(knot(column, row + 1), knot(column + 1, row + 1), fx), fy);
}

/** The parts of the picture that do not move, by pixel. */
struct Still {
    std::vector<float> skin[2]; ///< With the nose on the left, on the right.
    std::vector<float> sclera;

    Still() {
        for (uint32_t v = 0; v < kEyeHeight; v++)
            for (uint32_t u = 0; u < kEyeWidth; u++)
                add(float(u), float(v));
    }

  private:
    void add(float x, float y) {
        const float texture = 14 * grain(x / 22, y / 16) + 9 * grain(x / 5, y / 4) + 5 * grain(x / 2, y / 2);
        for (const float nasal : {-1.0f, 1.0f})
            skin[nasal > 0].push_back(150 - 55 * std::hypot((x - 200 - 50 * nasal) / 260, (y - 180) / 260) + texture);
        const float fromMiddle = std::hypot((x - 200) / 190, (y - 215) / 120);
        sclera.push_back(205 - 70 * fromMiddle * fromMiddle + 6 * grain(x / 9, y / 9));
    }
};

const Still &still() {
    static const Still &it = *new Still; // never destroyed: a thread may draw while the process ends
    return it;
}

size_t pixelAt(float x, float y) { return size_t(y) * kEyeWidth + size_t(x); }

/** exp(-x), or 0 where that is less than anybody can see. */
float fading(float x) { return x > 16 ? 0 : std::exp(-x); }

float skin(const Eye &eye, float x, float y) {
    const float fold = y - upperLid(eye, x) + 26 + 12 * eye.openness;
    return still().skin[eye.nasal > 0][pixelAt(x, y)] - 30 * fading(fold * fold / 40);
}

float sclera(const Eye &eye, float x, float y) {
    return still().sclera[pixelAt(x, y)] - 60 * fading(std::max(0.0f, y - upperLid(eye, x)) / 16);
}

/** At a spot off the centre of the iris: noise along a circle makes spokes. */
float iris(float dx, float dy, float radius) {
    const float x = dx / std::max(radius, 1.0f), y = dy / std::max(radius, 1.0f);
    const float spokes = 26 * grain(2.3f * x, 2.3f * y) + 30 * grain(9.5f * x, 9.5f * y + radius / 40);
    const float collar = 22 * std::exp(-std::pow((radius - 0.58f * kIris_px) / 7, 2.0f));
    const float limbus = 60 * inside(kIris_px - 9 - radius, 14);
    return 78 + spokes + collar - limbus;
}

float glints(const Eye &eye, float x, float y) {
    float light = 0;
    for (const Spot at : eye.lamps) {
        const float dx = (x - at.x) / 3.4f, dy = (y - at.y) / 3.0f;
        light += 260 * fading(dx * dx + dy * dy);
    }
    return light;
}

float lashes(const Eye &eye, float x, float y) {
    const float above = upperLid(eye, x) - y;
    if (above < -4 || above > 30)
        return 0;
    const float bent = (x - 200) * (1 - above / 320) / 7;
    const float strand = std::abs(bent - std::floor(bent) - 0.5f) * 2;
    const float aside = std::min(1.0f, std::abs(x - 200) / 165);
    const float end = (16 + 12 * grain(std::floor(bent) + 500, 1)) * (1 - aside * aside);
    return above > end || end < 1 ? 0 : inside(0.75f - strand, 0.5f) * std::min(1.0f, 1 - above / end);
}

float ball(const Eye &eye, float x, float y) {
    const float dx = (x - eye.iris.x) / eye.squeeze, dy = y - eye.iris.y;
    const float radius = std::hypot(dx, dy);
    float grey = sclera(eye, x, y);
    if (radius < kIris_px + 6)
        grey = mixed(grey, iris(dx, dy, radius), inside(radius - kIris_px, 5));
    grey = mixed(grey, 14, inside(radius - eye.pupil_px, 3));
    return grey + (radius < kIris_px + 20 ? glints(eye, x, y) : 0);
}

float eyeGrey(const Eye &eye, float x, float y) {
    const float lids = std::max(upperLid(eye, x) - y, y - lowerLid(eye, x));
    float grey = lids > 3    ? skin(eye, x, y)
                 : lids < -3 ? ball(eye, x, y)
                             : mixed(skin(eye, x, y), ball(eye, x, y), inside(lids, 3));
    grey -= 50 * fading(lids * lids / 18);
    return mixed(grey, 30, 0.85f * lashes(eye, x, y));
}

} // namespace

void renderEye(EyeCamera camera, double phase, uint8_t *grey, size_t stride_bytes, Noise noise) {
    const Eye eye = eyeAt(camera, float(phase - std::floor(phase)));
    std::vector<float> row(kEyeWidth);
    for (uint32_t v = 0; v < kEyeHeight; v++) {
        for (uint32_t u = 0; u < kEyeWidth; u++)
            row[u] = eyeGrey(eye, float(u), float(v));
        addNoise(row.data(), int(kEyeWidth), noise, size_t(v) * kEyeWidth);
        for (uint32_t u = 0; u < kEyeWidth; u++) {
            grey[v * stride_bytes + u] = uint8_t(std::clamp(row[u] + 0.5f, 0.0f, 255.0f));
        }
    }
}

} // namespace ml2sim
