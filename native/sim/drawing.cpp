// ml2sim_draw: the images of a camera, rendered before it streams.
#include <algorithm>
#include <optional>
#include <string>

#include "ml2sim.h"
#include "render_plans.h"

namespace ml2sim {
namespace {

std::optional<RenderPlan> depthPlan(const std::string &camera, const ml2sim_images &images) {
    const auto mode = std::find_if(std::begin(kDepthModes), std::end(kDepthModes), [&](const DepthMode &candidate) {
        return kDepthStreams[candidate.type].name == camera && candidate.delivered_hz == images.rate_hz;
    });
    if (mode == std::end(kDepthModes) || !isOnMains(*mode))
        return {};
    return depthRenderPlan({mode->type, images.depth_planes, images.rate_hz});
}

std::optional<RenderPlan> planOf(const ml2sim_images &images) {
    const std::string camera = images.camera;
    const auto exposure =
        images.low_exposure != 0 ? MLWorldCameraFrameType_LowExposure : MLWorldCameraFrameType_NormalExposure;
    for (const auto id : {MLWorldCameraIdentifier_Left, MLWorldCameraIdentifier_Right, MLWorldCameraIdentifier_Center})
        if (auto plan = worldRenderPlan(id, exposure); plan.name == camera)
            return plan;
    for (const auto id : {EyeCamera::LeftTemple, EyeCamera::LeftNasal, EyeCamera::RightNasal, EyeCamera::RightTemple})
        if (auto plan = eyeRenderPlan(id); plan.name == camera)
            return plan;
    const bool isMixed = camera == "mixed_reality";
    if (isMixed || camera == "color") {
        const ml2sim_color_request request = {images.width, images.height, images.rate_hz, isMixed};
        return isColorOffered(request) ? std::optional(colorRenderPlan(request)) : std::nullopt;
    }
    return depthPlan(camera, images);
}

} // namespace
} // namespace ml2sim

using namespace ml2sim;

int32_t ml2sim_draw(const ml2sim_images *images) {
    const auto plan = planOf(*images);
    if (!plan)
        return -1;
    const auto cache = FrameCache::of(*plan);
    for (size_t i = 0; i < plan->count && cache->isInFolder(); i++)
        cache->frame(i);
    return cache->isInFolder() ? 0 : 1;
}
