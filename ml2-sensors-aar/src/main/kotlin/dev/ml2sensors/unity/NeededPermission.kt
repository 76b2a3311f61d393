package dev.ml2sensors.unity

import kotlinx.serialization.Serializable

/** One row of [Ml2Unity.permissionsNeeded]. */
@Serializable
internal class NeededPermission(val permission: String, val reason: String, val streams: List<String>)
