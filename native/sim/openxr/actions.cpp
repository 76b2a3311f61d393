// Actions of the eyes and of the controller.
#include <algorithm>

#include "../clock.h"
#include "../settings.h"
#include "entry_points.h"
#include "eyes_and_hands.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

struct ActionSet : Object {
    bool isAttached = false;
};
struct Action : Object {
    XrActionType type;
    std::string input; ///< The binding, after the part of the user; empty: none.
    bool wasSynced = false;
};

struct Profile {
    std::string path;
    const char *extension;
    std::vector<std::string> users;
    std::map<std::string, XrActionType> inputs;
};

const std::vector<Profile> kProfiles = {
    {"/interaction_profiles/ext/eye_gaze_interaction",
     XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME,
     {"/user/eyes_ext"},
     {{"/input/gaze_ext/pose", XR_ACTION_TYPE_POSE_INPUT}}},
    {"/interaction_profiles/ml/ml2_controller",
     XR_ML_ML2_CONTROLLER_INTERACTION_EXTENSION_NAME,
     {"/user/hand/left", "/user/hand/right"},
     {{"/input/menu/click", XR_ACTION_TYPE_BOOLEAN_INPUT},
      {"/input/shoulder/click", XR_ACTION_TYPE_BOOLEAN_INPUT},
      {"/input/trigger/click", XR_ACTION_TYPE_BOOLEAN_INPUT},
      {"/input/trigger/value", XR_ACTION_TYPE_FLOAT_INPUT},
      {"/input/trackpad/x", XR_ACTION_TYPE_FLOAT_INPUT},
      {"/input/trackpad/y", XR_ACTION_TYPE_FLOAT_INPUT},
      {"/input/trackpad/click", XR_ACTION_TYPE_BOOLEAN_INPUT},
      {"/input/trackpad/force", XR_ACTION_TYPE_FLOAT_INPUT},
      {"/input/trackpad/touch", XR_ACTION_TYPE_BOOLEAN_INPUT},
      {"/input/aim/pose", XR_ACTION_TYPE_POSE_INPUT},
      {"/input/grip/pose", XR_ACTION_TYPE_POSE_INPUT}}},
};

const Profile &profileOf(XrPath path) {
    const auto found = std::find_if(kProfiles.begin(), kProfiles.end(),
                                    [&](const Profile &profile) { return profile.path == textOf(path); });
    if (found == kProfiles.end() || runtime().extensions.count(found->extension) == 0)
        misuse(ML2SIM_XR_MISUSE_EXTENSION, XR_ERROR_PATH_UNSUPPORTED,
               textOf(path) + " without the extension that has it");
    return *found;
}

/** Binds an action to an input of the profile, which must have the action's type. */
void bind(Action &action, const Profile &profile, const std::string &path) {
    for (const auto &user : profile.users) {
        const auto input =
            path.rfind(user, 0) == 0 ? profile.inputs.find(path.substr(user.size())) : profile.inputs.end();
        if (input != profile.inputs.end() && input->second == action.type) {
            action.input = input->first;
            return;
        }
    }
    misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_PATH_UNSUPPORTED,
           profile.path + " has no input " + path + " of the action's type");
}

std::optional<Pose> poseOf(const Action &action, XrTime time) {
    const bool isGaze = action.input == "/input/gaze_ext/pose";
    const bool isController = action.input == "/input/grip/pose" || action.input == "/input/aim/pose";
    if (!action.wasSynced || (isController && number(Key::FaultControllerTracking) != 0) || !(isGaze || isController))
        return std::nullopt;
    return compose(headAt(time), isGaze ? gazeInHead(time) : controllerInHead(time));
}

/** Returns the value of an input of the controller. */
float valueOf(const std::string &input) {
    const auto now = controllerInputAt(mlTimeNow());
    const std::map<std::string, float> values = {
        {"/input/menu/click", now.menu},
        {"/input/shoulder/click", now.bumper},
        {"/input/trigger/value", now.trigger},
        {"/input/trackpad/x", now.x},
        {"/input/trackpad/y", now.y},
        {"/input/trackpad/force", now.force},
        {"/input/trackpad/touch", now.isTouched},
    };
    const auto found = values.find(input);
    return found == values.end() ? 0 : found->second;
}

template <class State>
XrResult getState(XrSession session, const XrActionStateGetInfo *getInfo, State *out, XrActionType type,
                  XrStructureType stateType) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info = requireType(getInfo, XR_TYPE_ACTION_STATE_GET_INFO, "XrActionStateGetInfo");
        auto &state = requireType(out, stateType, "state");
        const auto &action = find<Action>(info.action, "action");
        if (action.type != type)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_ACTION_TYPE_MISMATCH, "the state of an action of another type");
        if (!static_cast<const ActionSet &>(*runtime().objects.at(action.parent)).isAttached)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_ACTIONSET_NOT_ATTACHED, "an action that is not attached");
        state.isActive = action.wasSynced && !action.input.empty() && !isOn(Key::FaultInputDisconnected);
        state.currentState = state.isActive ? static_cast<decltype(state.currentState)>(valueOf(action.input)) : 0;
    });
}

} // namespace

XrResult xrCreateActionSet(XrInstance instance, const XrActionSetCreateInfo *createInfo, XrActionSet *actionSet) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        requireType(createInfo, XR_TYPE_ACTION_SET_CREATE_INFO, "XrActionSetCreateInfo");
        requireNonNull(actionSet, "actionSet") =
            registerObject<XrActionSet>(number(instance), std::make_unique<ActionSet>());
    });
}

XrResult xrDestroyActionSet(XrActionSet actionSet) { return destroyHandle<ActionSet>(actionSet, "action set"); }

XrResult xrCreateAction(XrActionSet actionSet, const XrActionCreateInfo *createInfo, XrAction *action) {
    return entry([&](auto &) {
        if (find<ActionSet>(actionSet, "action set").isAttached)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "an action after attaching");
        const auto &info = requireType(createInfo, XR_TYPE_ACTION_CREATE_INFO, "XrActionCreateInfo");
        auto created = std::make_unique<Action>();
        created->type = info.actionType;
        requireNonNull(action, "action") = registerObject<XrAction>(number(actionSet), std::move(created));
    });
}

XrResult xrDestroyAction(XrAction action) { return destroyHandle<Action>(action, "action"); }

XrResult xrSuggestInteractionProfileBindings(XrInstance instance, const XrInteractionProfileSuggestedBinding *given) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &suggestion =
            requireType(given, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, "XrInteractionProfileSuggestedBinding");
        const auto &profile = profileOf(suggestion.interactionProfile);
        if (runtime().keys.text("fault.profile.refused") == profile.path)
            return XR_ERROR_PATH_UNSUPPORTED;
        for (uint32_t i = 0; i < suggestion.countSuggestedBindings; i++) {
            const auto &binding = suggestion.suggestedBindings[i];
            auto &action = find<Action>(binding.action, "action");
            if (find<ActionSet>(reinterpret_cast<XrActionSet>(action.parent), "action set").isAttached)
                misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "bindings after attaching");
            bind(action, profile, textOf(binding.binding));
        }
        return XR_SUCCESS;
    });
}

XrResult xrAttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo *attachInfo) {
    return entry([&](auto &) {
        auto &state = find<Session>(session, "session");
        const auto &info =
            requireType(attachInfo, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, "XrSessionActionSetsAttachInfo");
        if (state.hasActionSets)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "action sets attached twice");
        for (uint32_t i = 0; i < info.countActionSets; i++)
            find<ActionSet>(info.actionSets[i], "action set").isAttached = true;
        state.hasActionSets = true;
    });
}

XrResult xrCreateActionSpace(XrSession session, const XrActionSpaceCreateInfo *createInfo, XrSpace *space) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info = requireType(createInfo, XR_TYPE_ACTION_SPACE_CREATE_INFO, "XrActionSpaceCreateInfo");
        find<Action>(info.action, "action");
        auto created = std::make_unique<Space>();
        created->at = [action = number(info.action)](XrTime time) -> std::optional<Pose> {
            const auto found = runtime().objects.find(action);
            if (found == runtime().objects.end())
                return {};
            return poseOf(static_cast<const Action &>(*found->second), time);
        };
        requireNonNull(space, "space") = registerObject<XrSpace>(number(session), std::move(created));
    });
}

XrResult xrSyncActions(XrSession session, const XrActionsSyncInfo *syncInfo) {
    return entry([&](auto &) {
        const auto &state = find<Session>(session, "session");
        const auto &info = requireType(syncInfo, XR_TYPE_ACTIONS_SYNC_INFO, "XrActionsSyncInfo");
        for (uint32_t i = 0; i < info.countActiveActionSets; i++) {
            const auto set = info.activeActionSets[i].actionSet;
            if (!find<ActionSet>(set, "action set").isAttached)
                misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_ACTIONSET_NOT_ATTACHED, "an action set that is not attached");
            for (auto &[handle, object] : runtime().objects)
                if (auto *action = dynamic_cast<Action *>(object.get()); action && action->parent == number(set))
                    action->wasSynced = state.isFocused();
        }
        return state.isFocused() ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
    });
}

XrResult xrGetActionStateBoolean(XrSession session, const XrActionStateGetInfo *getInfo, XrActionStateBoolean *state) {
    return getState(session, getInfo, state, XR_ACTION_TYPE_BOOLEAN_INPUT, XR_TYPE_ACTION_STATE_BOOLEAN);
}

XrResult xrGetActionStateFloat(XrSession session, const XrActionStateGetInfo *getInfo, XrActionStateFloat *state) {
    return getState(session, getInfo, state, XR_ACTION_TYPE_FLOAT_INPUT, XR_TYPE_ACTION_STATE_FLOAT);
}

} // namespace ml2sim::xr
