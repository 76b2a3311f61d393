package dev.ml2sensors.app.screen

import dev.ml2sensors.app.R
import dev.ml2sensors.app.status.appStatus
import dev.ml2sensors.app.status.streamStatus
import dev.ml2sensors.table.StreamTable
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals
import kotlin.test.assertNotEquals
import kotlin.test.assertNull

class QuestionTest {
    private val wanted = listOf("world_left", "color", "depth", "battery").map { streamStatus(it) }

    @Test
    fun onePermissionIsAskedForAtATimeWithTheStreamsItIsFor() {
        val nothing = mapOf(CAMERA to false, DEPTH to false)
        assertEquals(Question(CAMERA, listOf("world_left", "color")), next(nothing))
        assertEquals(Question(DEPTH, listOf("depth")), next(nothing, declined = setOf(CAMERA)))
        assertEquals(Question(DEPTH, listOf("depth")), next(mapOf(CAMERA to true, DEPTH to false)))
    }

    @Test
    fun nothingIsAskedForThatIsGrantedOrDeclinedOrThatNobodyWants() {
        assertNull(next(mapOf(CAMERA to true, DEPTH to true)))
        assertNull(next(mapOf(CAMERA to false, DEPTH to false), declined = setOf(CAMERA, DEPTH)))
        val idle = appStatus(permissions = mapOf(CAMERA to false))
        assertNull(Question.next(idle, emptySet()))
    }

    @Test
    fun everyPermissionThatIsAskedForHasAReasonOfItsOwn() {
        val normal = "com.magicleap.permission.HAND_TRACKING"
        val asked = StreamTable.all.flatMap { it.permissions }.toSet() - normal
        for (permission in asked) {
            assertNotEquals(R.string.reason_other, Question(permission, emptyList()).reason, permission)
        }
    }

    private fun next(permissions: Map<String, Boolean>, declined: Set<String> = emptySet()) =
        Question.next(appStatus(streams = wanted, permissions = permissions), declined)

    private companion object {
        const val CAMERA = "android.permission.CAMERA"
        const val DEPTH = "com.magicleap.permission.DEPTH_CAMERA"
    }
}
