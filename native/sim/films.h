// The films of the cameras, for whoever shows them.
#pragma once

#include "depth_modes.h"
#include "film.h"
#include "ml_world_camera.h"
#include "scene/render.h"

namespace ml2sim {

FilmPlan worldFilm(MLWorldCameraIdentifier camera, MLWorldCameraFrameType exposure);

/** A frame has the planes of the choice one after the other, in the order of the bits of MLDepthCameraFlags. */
FilmPlan depthFilm(const DepthChoice &choice);

FilmPlan eyeFilm(EyeCamera camera);

} // namespace ml2sim
