package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.status.appStatus
import dev.ml2sensors.app.status.streamStatus
import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertNotEquals
import kotlin.test.assertNull

class PermissionRequestTest {
    private val requested = listOf("world_left", "color", "depth", "battery").map { streamStatus(it) }

    @Test
    fun onePermissionIsRequestedAtATimeWithItsStreams() {
        val nothing = mapOf(CAMERA to false, DEPTH to false)
        assertEquals(PermissionRequest(CAMERA, listOf("world_left", "color")), next(nothing))
        assertEquals(PermissionRequest(DEPTH, listOf("depth")), next(nothing, declined = setOf(CAMERA)))
        assertEquals(PermissionRequest(DEPTH, listOf("depth")), next(mapOf(CAMERA to true, DEPTH to false)))
    }

    @Test
    fun grantedDeclinedAndUnneededPermissionsAreNotRequested() {
        assertNull(next(mapOf(CAMERA to true, DEPTH to true)))
        assertNull(next(mapOf(CAMERA to false, DEPTH to false), declined = setOf(CAMERA, DEPTH)))
        val idle = appStatus(permissions = mapOf(CAMERA to false))
        assertNull(PermissionRequest.next(idle, emptySet()))
    }

    @Test
    fun everyRequestedPermissionHasItsOwnReason() {
        val normal =
            listOf("HAND_TRACKING", "MARKER_TRACKING", "SPACE_MANAGER").map { "com.magicleap.permission.$it" }
        val asked = StreamTable.all.flatMap { it.permissions }.toSet() - normal.toSet()
        for (permission in asked) {
            assertNotEquals(R.string.reason_other, PermissionRequest(permission, emptyList()).reason, permission)
        }
    }

    private fun next(permissions: Map<String, Boolean>, declined: Set<String> = emptySet()) =
        PermissionRequest.next(appStatus(streams = requested, permissions = permissions), declined)

    private companion object {
        const val CAMERA = "android.permission.CAMERA"
        const val DEPTH = "com.magicleap.permission.DEPTH_CAMERA"
    }
}
