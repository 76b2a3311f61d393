// Functions of the cameras and the perception system that ml2sim_reset and ml2sim_set need.
#pragma once

namespace ml2sim {

bool isDepthCameraOpen();
bool isWorldCameraOpen();
bool isEyeCameraOpen();

/** Remove all clients, for ml2sim_reset. */
void resetDepthCamera();
void resetWorldCamera();
void resetEyeCamera();
void resetPerception();

} // namespace ml2sim
