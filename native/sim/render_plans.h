// The render plans of the cameras, shared by the simulated SDK and the simulated OpenXR runtime.
#pragma once

#include "depth_modes.h"
#include "frame_cache.h"
#include "ml2sim.h"
#include "ml_world_camera.h"
#include "scene/render.h"

namespace ml2sim {

/** The exposures of a world camera in moderate light: normal and low. */
constexpr int64_t kWorldExposureNanos[] = {5000000, 1000000};
constexpr int64_t kColorExposureNanos = 8000000;

RenderPlan worldRenderPlan(MLWorldCameraIdentifier camera, MLWorldCameraFrameType exposure);

/** A frame has the planes of the choice one after the other, in the order of the bits of MLDepthCameraFlags. */
RenderPlan depthRenderPlan(const DepthChoice &choice);

RenderPlan eyeRenderPlan(EyeCamera camera);

/** Returns true if the colour camera has the size, rate and mode. */
bool isColorOffered(const ml2sim_color_request &request);

/** A frame has the size of its JPEG in four bytes, then the JPEG. */
RenderPlan colorRenderPlan(const ml2sim_color_request &request);

} // namespace ml2sim
