// The marker detector: what it sees of the room's tags, and its rules.
#include <algorithm>
#include <cstring>

#include "../clock.h"
#include "../head_path.h"
#include "../tracking.h"
#include "entry_points.h"
#include "session.h"
#include "tags.h"

namespace ml2sim::xr {
namespace {

/** Atoms of markers begin here, so that one is never a marker's number. */
constexpr XrMarkerML kFirstAtom = 0x7a600;

struct Detector : Object {
    XrMarkerTypeML type;
    std::string dictionary;
    bool usesColorCamera = false;
    float length_m = 0;        ///< 0: the detector estimates it.
    int64_t readyAt = 0;       ///< MLTime of the end of the last snapshot; 0 before the first.
    bool wasSeenReady = false; ///< The app has read READY since the last snapshot.
    uint64_t snapshots = 0;
    std::vector<int> seen; ///< The tags of the last snapshot.
};

Detector &detectorOf(XrMarkerDetectorML detector) { return find<Detector>(detector, "marker detector"); }

template <class Info> const Info *chained(const void *next, XrStructureType type) {
    for (auto *it = static_cast<const XrBaseInStructure *>(next); it != nullptr; it = it->next)
        if (it->type == type)
            return reinterpret_cast<const Info *>(it);
    return nullptr;
}

template <class Info> const Info &required(const void *next, XrStructureType type, const char *name) {
    const auto *info = chained<Info>(next, type);
    if (info == nullptr)
        misuse(ML2SIM_XR_MISUSE_TYPE, XR_ERROR_VALIDATION_FAILURE, std::string("a detector without ") + name);
    return *info;
}

/** Returns the name of the room's tags that a detector reads. */
std::string dictionaryOf(const XrMarkerDetectorCreateInfoML &info) {
    switch (info.markerType) {
    case XR_MARKER_TYPE_ARUCO_ML: {
        // The smaller dictionaries are the beginnings of the larger ones.
        static const char *const families[] = {"4X4_50", "5X5_100", "6X6", "7X7"};
        return families[required<XrMarkerDetectorArucoInfoML>(info.next, XR_TYPE_MARKER_DETECTOR_ARUCO_INFO_ML,
                                                              "XrMarkerDetectorArucoInfoML")
                            .arucoDict /
                        4];
    }
    case XR_MARKER_TYPE_APRIL_TAG_ML: {
        static const char *const families[] = {"16h5", "25h9", "36h10", "36h11"};
        return families[required<XrMarkerDetectorAprilTagInfoML>(info.next, XR_TYPE_MARKER_DETECTOR_APRIL_TAG_INFO_ML,
                                                                 "XrMarkerDetectorAprilTagInfoML")
                            .aprilTagDict];
    }
    default:
        return "QR";
    }
}

/** Reads the size, which an app may leave out if the runtime can estimate it. */
float lengthFrom(const XrMarkerDetectorCreateInfoML &info) {
    if (runtime().keys.whole("markers.estimates_size") != 0 &&
        chained<XrMarkerDetectorSizeInfoML>(info.next, XR_TYPE_MARKER_DETECTOR_SIZE_INFO_ML) == nullptr)
        return 0;
    return required<XrMarkerDetectorSizeInfoML>(info.next, XR_TYPE_MARKER_DETECTOR_SIZE_INFO_ML,
                                                "XrMarkerDetectorSizeInfoML")
        .markerLength;
}

Pose fromXr(const XrPosef &pose) {
    const auto &q = pose.orientation;
    return {{q.x, q.y, q.z, q.w}, {pose.position.x, pose.position.y, pose.position.z}};
}

bool isFalse(int tag) { return tag == kFalseTag; }

std::vector<int> seenBy(const Detector &detector) {
    auto tags = detector.dictionary == text(Key::Tags) ? visibleTags(detector.usesColorCamera, mlTimeNow())
                                                       : std::vector<int>{};
    if (runtime().keys.whole("fault.markers.false") != 0 && detector.snapshots % 2 == 1) {
        tags.resize(std::min(tags.size(), mostSeen() - 1));
        tags.push_back(kFalseTag);
    }
    return tags;
}

/** Refuses what only a snapshot that the app knows to be ready can answer. */
void requireReady(const Detector &detector) {
    if (!detector.wasSeenReady)
        misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, "markers before the snapshot was seen to be ready");
}

int tagOf(const Detector &detector, XrMarkerML marker) {
    requireReady(detector);
    const int tag = static_cast<int>(marker - kFirstAtom);
    if (std::find(detector.seen.begin(), detector.seen.end(), tag) == detector.seen.end())
        throw Refusal{XR_ERROR_MARKER_INVALID_ML};
    return tag;
}

/** Returns the pose while the marker is tracked: in sight of a detector that exists. */
std::optional<Pose> placeOf(XrMarkerDetectorML handle, int tag, XrTime time) {
    const auto found = runtime().objects.find(number(handle));
    if (found == runtime().objects.end() || runtime().keys.whole("fault.markers.untracked") != 0)
        return {};
    const auto &detector = static_cast<const Detector &>(*found->second);
    if (isFalse(tag))
        return compose(headAt(time), {{}, {0.3, 0.1, -1.0}});
    const auto visible = visibleTags(detector.usesColorCamera, time);
    if (std::find(visible.begin(), visible.end(), tag) == visible.end())
        return {};
    return seenFrom(tag, time);
}

} // namespace

XrResult xrCreateMarkerDetectorML(XrSession session, const XrMarkerDetectorCreateInfoML *createInfo,
                                  XrMarkerDetectorML *markerDetector) {
    return entry([&](auto &lock) {
        lock.unlock(); // the first call builds the scene
        HeadPath::scene();
        lock.lock();
        find<Session>(session, "session");
        const auto &info =
            requireType(createInfo, XR_TYPE_MARKER_DETECTOR_CREATE_INFO_ML, "XrMarkerDetectorCreateInfoML");
        refuseIf("fault.markers.denied", XR_ERROR_MARKER_DETECTOR_PERMISSION_DENIED_ML);
        auto detector = std::make_unique<Detector>();
        detector->type = info.markerType;
        detector->dictionary = dictionaryOf(info);
        detector->length_m = lengthFrom(info);
        if (info.profile == XR_MARKER_DETECTOR_PROFILE_CUSTOM_ML)
            detector->usesColorCamera =
                required<XrMarkerDetectorCustomProfileInfoML>(info.next, XR_TYPE_MARKER_DETECTOR_CUSTOM_PROFILE_INFO_ML,
                                                              "XrMarkerDetectorCustomProfileInfoML")
                    .cameraHint == XR_MARKER_DETECTOR_CAMERA_RGB_CAMERA_ML;
        requireNonNull(markerDetector, "detector") =
            registerObject<XrMarkerDetectorML>(number(session), std::move(detector));
    });
}

XrResult xrDestroyMarkerDetectorML(XrMarkerDetectorML markerDetector) {
    return destroyHandle<Detector>(markerDetector, "marker detector");
}

XrResult xrSnapshotMarkerDetectorML(XrMarkerDetectorML markerDetector, XrMarkerDetectorSnapshotInfoML *snapshotInfo) {
    return entry([&](auto &) {
        auto &detector = detectorOf(markerDetector);
        requireType(snapshotInfo, XR_TYPE_MARKER_DETECTOR_SNAPSHOT_INFO_ML, "XrMarkerDetectorSnapshotInfoML");
        detector.snapshots++;
        detector.seen = seenBy(detector);
        detector.readyAt = runtime().keys.whole("fault.markers.stuck") != 0
                               ? INT64_MAX
                               : mlTimeNow() + runtime().keys.whole("markers.delay_ms") * 1000000;
        detector.wasSeenReady = false;
    });
}

XrResult xrGetMarkerDetectorStateML(XrMarkerDetectorML markerDetector, XrMarkerDetectorStateML *state) {
    return entry([&](auto &) {
        auto &detector = detectorOf(markerDetector);
        auto &out = requireType(state, XR_TYPE_MARKER_DETECTOR_STATE_ML, "XrMarkerDetectorStateML");
        if (detector.readyAt == 0)
            misuse(ML2SIM_XR_MISUSE_ORDER, XR_ERROR_CALL_ORDER_INVALID, "the state of a detector without a snapshot");
        if (mlTimeNow() < detector.readyAt)
            out.state = XR_MARKER_DETECTOR_STATUS_PENDING_ML;
        else
            out.state = runtime().keys.whole("fault.markers.fails") != 0 ? XR_MARKER_DETECTOR_STATUS_ERROR_ML
                                                                         : XR_MARKER_DETECTOR_STATUS_READY_ML;
        detector.wasSeenReady = out.state == XR_MARKER_DETECTOR_STATUS_READY_ML;
    });
}

XrResult xrGetMarkersML(XrMarkerDetectorML markerDetector, uint32_t capacity, uint32_t *count, XrMarkerML *markers) {
    return entry([&](auto &) {
        const auto &detector = detectorOf(markerDetector);
        requireReady(detector);
        std::vector<XrMarkerML> atoms;
        for (const int tag : detector.seen)
            atoms.push_back(kFirstAtom + static_cast<XrMarkerML>(tag));
        return enumerate(atoms, capacity, count, markers);
    });
}

XrResult xrGetMarkerReprojectionErrorML(XrMarkerDetectorML markerDetector, XrMarkerML marker, float *meters) {
    return entry([&](auto &) {
        const int tag = tagOf(detectorOf(markerDetector), marker);
        requireNonNull(meters, "reprojection error") = isFalse(tag) ? 0.02f : 0.0005f;
    });
}

XrResult xrGetMarkerLengthML(XrMarkerDetectorML markerDetector, XrMarkerML marker, float *meters) {
    return entry([&](auto &) {
        const auto &detector = detectorOf(markerDetector);
        tagOf(detector, marker);
        requireNonNull(meters, "length") = detector.length_m > 0 ? detector.length_m : float(kMarkerSide_m);
    });
}

XrResult xrGetMarkerNumberML(XrMarkerDetectorML markerDetector, XrMarkerML marker, uint64_t *value) {
    return entry([&](auto &) {
        const auto &detector = detectorOf(markerDetector);
        const int tag = tagOf(detector, marker);
        if (detector.type == XR_MARKER_TYPE_QR_ML)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_MARKER_DETECTOR_INVALID_DATA_QUERY_ML, "the number of a text");
        requireNonNull(value, "number") = static_cast<uint64_t>(tag);
    });
}

XrResult xrGetMarkerStringML(XrMarkerDetectorML markerDetector, XrMarkerML marker, uint32_t capacity, uint32_t *count,
                             char *buffer) {
    return entry([&](auto &) {
        const auto &detector = detectorOf(markerDetector);
        const auto content = textOfTag(tagOf(detector, marker));
        if (detector.type != XR_MARKER_TYPE_QR_ML)
            misuse(ML2SIM_XR_MISUSE_ARGUMENT, XR_ERROR_MARKER_DETECTOR_INVALID_DATA_QUERY_ML, "the text of a number");
        return enumerate(std::vector<char>(content.c_str(), content.c_str() + content.size() + 1), capacity, count,
                         buffer);
    });
}

XrResult xrCreateMarkerSpaceML(XrSession session, const XrMarkerSpaceCreateInfoML *createInfo, XrSpace *space) {
    return entry([&](auto &) {
        find<Session>(session, "session");
        const auto &info = requireType(createInfo, XR_TYPE_MARKER_SPACE_CREATE_INFO_ML, "XrMarkerSpaceCreateInfoML");
        const auto &detector = detectorOf(info.markerDetector);
        if (detector.parent != number(session))
            misuse(ML2SIM_XR_MISUSE_HANDLE, XR_ERROR_HANDLE_INVALID, "a marker detector of another session");
        const int tag = tagOf(detector, info.marker);
        auto created = std::make_unique<Space>();
        created->at = [handle = info.markerDetector, tag,
                       inMarker = info.poseInMarkerSpace](XrTime time) -> std::optional<Pose> {
            const auto place = placeOf(handle, tag, time);
            return place ? std::optional(compose(*place, fromXr(inMarker))) : std::nullopt;
        };
        requireNonNull(space, "space") = registerObject<XrSpace>(number(session), std::move(created));
    });
}

} // namespace ml2sim::xr
