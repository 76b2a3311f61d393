package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.table.StreamTable

/** The next [permission] to request from the user, and the [streams] that need it. */
internal data class PermissionRequest(val permission: String, val streams: List<String>) {
    /** The string resource that explains why the permission is needed. */
    val reason: Int get() = REASONS[permission] ?: R.string.reason_other

    companion object {
        private val REASONS = mapOf(
            "android.permission.CAMERA" to R.string.reason_camera,
            "com.magicleap.permission.DEPTH_CAMERA" to R.string.reason_depth,
            "com.magicleap.permission.EYE_CAMERA" to R.string.reason_eye_camera,
            "com.magicleap.permission.EYE_TRACKING" to R.string.reason_eye_tracking,
        )

        /** Returns the next request, or null if no requested stream lacks a permission that was not [declined] before. */
        fun next(status: AppStatus, declined: Set<String>): PermissionRequest? {
            val requested = status.streams.mapNotNull { StreamTable.byId(it.id) }
            val missing = requested.flatMap { it.permissions }.firstOrNull {
                status.permissions[it] == false && it !in declined
            } ?: return null
            return PermissionRequest(missing, requested.filter { missing in it.permissions }.map { it.id })
        }
    }
}
