#include "render.h"

namespace ml2sim {
namespace {

template <class Lens> void fill(RayTable &table, const Lens &lens) {
    table.width = lens.width;
    table.height = lens.height;
    table.radians_per_pixel = float(1 / lens.fx);
    const size_t pixels = size_t(lens.width) * lens.height;
    for (std::vector<float> *component : {&table.x, &table.y, &table.z})
        component->reserve(pixels);
    for (uint32_t v = 0; v < lens.height; v++) {
        for (uint32_t u = 0; u < lens.width; u++) {
            const Vec3 ray = lens.unproject({double(u), double(v)});
            table.x.push_back(float(ray.x));
            table.y.push_back(float(ray.y));
            table.z.push_back(float(ray.z));
        }
    }
}

} // namespace

RayTable::RayTable(const FisheyeTangential &lens) { fill(*this, lens); }
RayTable::RayTable(const PlumbBob &lens) { fill(*this, lens); }

} // namespace ml2sim
