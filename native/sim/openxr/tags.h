// The tags of the room, as a marker detector sees them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/geometry.h"
#include "scene/layout.h"

namespace ml2sim::xr {

/** Returns the most markers of a snapshot. */
size_t mostSeen();

/** A tag that no card of the room has. */
constexpr int kFalseTag = 77;

/** Returns the tags in the images of the world cameras or the RGB camera: whole, large and frontal enough, not hidden.
 */
std::vector<int> visibleTags(bool byColorCamera, int64_t mltime);

/** Returns the pose of a tag in the world as reported: origin in its centre, x right, y up, z out of the face. */
Pose seenFrom(int tag, int64_t mltime);

/** Returns the content of a QR code. */
std::string textOfTag(int tag);

} // namespace ml2sim::xr
