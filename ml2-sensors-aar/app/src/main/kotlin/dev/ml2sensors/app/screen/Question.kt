package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.status.AppStatus
import dev.ml2sensors.table.StreamTable

/** The one [permission] to ask the user for next, and for which [streams]. */
internal data class Question(val permission: String, val streams: List<String>) {
    /** In words that say what it is for. */
    val reason: Int get() = REASONS[permission] ?: R.string.reason_other

    companion object {
        private val REASONS = mapOf(
            "android.permission.CAMERA" to R.string.reason_camera,
            "com.magicleap.permission.DEPTH_CAMERA" to R.string.reason_depth,
            "com.magicleap.permission.EYE_CAMERA" to R.string.reason_eye_camera,
            "com.magicleap.permission.EYE_TRACKING" to R.string.reason_eye_tracking,
        )

        /** Null when the receiver wants nothing for which one is missing, but for those [declined] before. */
        fun next(status: AppStatus, declined: Set<String>): Question? {
            val wanted = status.streams.mapNotNull { StreamTable.byId(it.id) }
            val missing = wanted.flatMap { it.permissions }.firstOrNull {
                status.permissions[it] == false && it !in declined
            } ?: return null
            return Question(missing, wanted.filter { missing in it.permissions }.map { it.id })
        }
    }
}
