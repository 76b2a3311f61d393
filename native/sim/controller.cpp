// MLController*: the pose of the controller, and MLInput*: its buttons, trigger and touchpad.
#include "input.h"

#include <limits>

#include "clock.h"
#include "eyes_and_hands.h"
#include "tracker_registry.h"
#include "trackers.h"
#include "tracking.h"

namespace ml2sim {
namespace {

TrackerRegistry<NoState> trackers, inputs;

constexpr uint64_t kFrames = 0x434f4e54524f4c00;

uint32_t status() {
    static constexpr uint32_t kByFault[] = {MLControllerStatus_Active, MLControllerStatus_Active_Rotation_Only,
                                            MLControllerStatus_NotActive};
    return kByFault[static_cast<size_t>(number(Key::FaultControllerTracking))];
}

MLInputControllerStateEx stateNow() {
    MLInputControllerStateEx state = {};
    state.version = 1;
    if (isOn(Key::FaultInputDisconnected))
        return state;
    const auto input = controllerInputAt(mlTimeNow());
    state.type = MLInputControllerType_Device;
    state.is_connected = true;
    state.touch_pos_and_force[0] = {input.x, input.y, input.force};
    state.is_touch_active[0] = input.isTouched;
    state.trigger_normalized = isOn(Key::FaultInputUnusable) ? std::numeric_limits<float>::quiet_NaN() : input.trigger;
    state.button_state[MLInputControllerButton_Bumper] = input.bumper;
    state.button_state[MLInputControllerButton_Menu] = input.menu;
    return state;
}

} // namespace

bool anyControllerTracker() { return !trackers.isEmpty(); }

void resetController() {
    trackers.clear();
    inputs.clear();
}

std::optional<Pose> controllerInHead(const MLCoordinateFrameUID &id, int64_t mltime) {
    if (id.data[0] != kFrames || !anyControllerTracker() || status() == MLControllerStatus_NotActive)
        return std::nullopt;
    auto pose = controllerInHead(mltime);
    if (status() == MLControllerStatus_Active_Rotation_Only)
        pose.position = {};
    return pose;
}

} // namespace ml2sim

using namespace ml2sim;

MLResult MLControllerCreateEx(const MLControllerConfiguration *modes, MLHandle *out_tracker) {
    if (modes == nullptr || !modes->enable_fused6dof)
        return refuseArgument(__func__, "modes is null, or its enable_fused6dof is false");
    return trackers.create(__func__, out_tracker, Key::FaultControllerPermission, MLResult_PermissionDenied);
}

MLResult MLControllerDestroy(MLHandle tracker) { return trackers.destroy(__func__, tracker); }

MLResult MLControllerGetStateEx(MLHandle tracker, MLControllerSystemStateEx *inout_state) {
    if (const auto result = trackers.check(__func__, tracker))
        return result;
    if (const auto result = checkStructure(__func__, inout_state, 1))
        return result;
    inout_state->controller_state[0] = {0, {{kFrames, 1}}, {{kFrames, 2}}, status()};
    return MLResult_Ok;
}

MLResult ml2sim_MLInputCreate(MLHandle *out_tracker) {
    return inputs.createAnytime("MLInputCreate", out_tracker, Key::FaultInputCreate, MLResult_UnspecifiedFailure);
}

MLResult ml2sim_MLInputDestroy(MLHandle tracker) { return inputs.destroy("MLInputDestroy", tracker); }

MLResult ml2sim_MLInputGetControllerStateEx(MLHandle tracker,
                                            MLInputControllerStateEx out_states[MLInput_MaxControllers]) {
    constexpr auto kName = "MLInputGetControllerStateEx";
    if (const auto result = inputs.check(kName, tracker))
        return result;
    if (const auto result = checkStructure(kName, out_states, 1))
        return result;
    out_states[0] = stateNow();
    return MLResult_Ok;
}
