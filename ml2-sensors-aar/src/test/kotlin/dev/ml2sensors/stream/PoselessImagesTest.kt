package dev.ml2sensors.stream

import dev.ml2sensors.table.StreamTable
import dev.ml2sensors.wire.Event
import org.junit.jupiter.api.Test
import kotlin.test.assertEquals

class PoselessImagesTest {
    private val events = mutableListOf<Event>()
    private val images = PoselessImages(StreamTable.color, events::add)

    @Test
    fun theNumberIsReportedWhenItHasDoubledAndAtTheEnd() {
        repeat(130) { images.add(hasPose = false) }
        images.end()
        images.end()
        assertEquals(listOf(30, 60, 120, 130).map { "$it images of color had no pose since the stream began" }, texts())
        assertEquals(setOf("images_without_pose"), events.map { it.event }.toSet())
    }

    @Test
    fun imagesWithAPoseAreNotCounted() {
        repeat(60) { images.add(hasPose = it % 2 == 0) }
        assertEquals(listOf("30 images of color had no pose since the stream began"), texts())
    }

    @Test
    fun aStreamWhoseImagesAllHaveAPoseReportsNothing() {
        images.add(hasPose = true)
        images.end()
        assertEquals(emptyList(), texts())
    }

    private fun texts() = events.map { it.text }
}
