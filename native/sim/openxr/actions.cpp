// The functions of actions that gaze needs.
#include "entry_points.h"
#include "eyes_and_hands.h"
#include "session.h"

namespace ml2sim::xr {
namespace {

struct ActionSet : Object {
    bool isAttached = false;
};
struct Action : Object {
    bool isBoundToGaze = false;
    bool wasSynced = false;
};

constexpr auto kProfile = "/interaction_profiles/ext/eye_gaze_interaction";
constexpr auto kBinding = "/user/eyes_ext/input/gaze_ext/pose";

} // namespace

XrResult xrCreateActionSet(XrInstance instance, const XrActionSetCreateInfo *createInfo, XrActionSet *actionSet) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        requireType(createInfo, XR_TYPE_ACTION_SET_CREATE_INFO, "XrActionSetCreateInfo");
        requireNonNull(actionSet, "actionSet") =
            registerObject<XrActionSet>(number(instance), std::make_unique<ActionSet>());
        return XR_SUCCESS;
    });
}

XrResult xrDestroyActionSet(XrActionSet actionSet) {
    return entry([&](auto &) {
        find<ActionSet>(actionSet, "action set");
        destroy(number(actionSet), "action set");
        return XR_SUCCESS;
    });
}

XrResult xrCreateAction(XrActionSet actionSet, const XrActionCreateInfo *createInfo, XrAction *action) {
    return entry([&](auto &) {
        if (find<ActionSet>(actionSet, "action set").isAttached)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "an action after attaching");
        requireType(createInfo, XR_TYPE_ACTION_CREATE_INFO, "XrActionCreateInfo");
        requireNonNull(action, "action") = registerObject<XrAction>(number(actionSet), std::make_unique<Action>());
        return XR_SUCCESS;
    });
}

XrResult xrDestroyAction(XrAction action) {
    return entry([&](auto &) {
        find<Action>(action, "action");
        destroy(number(action), "action");
        return XR_SUCCESS;
    });
}

XrResult xrSuggestInteractionProfileBindings(XrInstance instance, const XrInteractionProfileSuggestedBinding *given) {
    return entry([&](auto &) {
        find<Instance>(instance, "instance");
        const auto &suggestion =
            requireType(given, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, "XrInteractionProfileSuggestedBinding");
        const bool isGaze = textOf(suggestion.interactionProfile) == kProfile;
        if (isGaze && runtime().extensions.count(XR_EXT_EYE_GAZE_INTERACTION_EXTENSION_NAME) == 0)
            misuse(ML2SIM_XR_MISUSE_EXTENSION, XR_ERROR_PATH_UNSUPPORTED, "gaze without XR_EXT_eye_gaze_interaction");
        for (uint32_t i = 0; i < suggestion.countSuggestedBindings; i++) {
            const auto &binding = suggestion.suggestedBindings[i];
            find<Action>(binding.action, "action").isBoundToGaze = isGaze && textOf(binding.binding) == kBinding;
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
        return XR_SUCCESS;
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
            const auto &state = static_cast<const Action &>(*found->second);
            return state.isBoundToGaze && state.wasSynced ? std::optional(compose(headAt(time), gazeInHead(time)))
                                                          : std::nullopt;
        };
        requireNonNull(space, "space") = registerObject<XrSpace>(number(session), std::move(created));
        return XR_SUCCESS;
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

} // namespace ml2sim::xr
