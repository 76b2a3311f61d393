package dev.ml2sensors.unity

import kotlinx.serialization.Serializable

/** One row of [Ml2Unity.permissionsNeeded]. */
@Serializable
internal class NeededPermission(val permission: String, val reason: String, val streams: List<String>) {
    companion object {
        /** Returns one row for each permission. [needing] has permissions with streams that need them. */
        fun of(needing: List<Pair<String, String>>): List<NeededPermission> =
            needing.groupBy({ it.first }, { it.second }).map { (permission, streams) ->
                NeededPermission(permission, "wanted for ${streams.joinToString()}", streams)
            }
    }
}
