// What control needs of the cameras, one file each.
#pragma once

namespace ml2sim {

bool isDepthCameraOpen();
bool isWorldCameraOpen();
bool isEyeCameraOpen();

/** Forgets their clients, for ml2sim_reset. */
void resetDepthCamera();
void resetWorldCamera();
void resetEyeCamera();
void resetPerception();

} // namespace ml2sim
