package dev.ml2sensors.app

import android.graphics.Bitmap
import android.graphics.Canvas
import android.view.View
import android.widget.TextView
import dev.ml2sensors.app.screen.Screen
import dev.ml2sensors.app.status.appStatus
import dev.ml2sensors.app.status.streamStatus
import dev.ml2sensors.wire.Status
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.Robolectric
import org.robolectric.RobolectricTestRunner
import org.robolectric.annotation.Config
import org.robolectric.annotation.GraphicsMode
import java.io.File
import kotlin.test.assertEquals
import kotlin.test.assertTrue

/** Lays out and draws the screen as Android does; the picture is build/reports/app.png. */
@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29], qualifiers = "w1000dp-h1100dp-mdpi")
@GraphicsMode(GraphicsMode.Mode.NATIVE)
class ScreenPictureTest {
    private val activity = Robolectric.buildActivity(MainActivity::class.java).setup().get()
    private val root = activity.findViewById<View>(R.id.main)

    @Test
    fun allTextsFitAndAreLargeEnoughToRead() {
        ScreenView(root).show(Screen.of(STATUS, RATES, emptySet()))
        val picture = draw()
        val folder = File("../../build/reports").apply { mkdirs() }
        File(folder, "app.png").outputStream().use { picture.compress(Bitmap.CompressFormat.PNG, 100, it) }
        for (view in texts(root)) {
            assertTrue(view.textSize >= 24, "${view.text}")
            assertEquals(0, (0 until view.lineCount).sumOf { view.layout.getEllipsisCount(it) }, "${view.text}")
        }
        val background = picture.getPixel(2, 2)
        assertEquals(activity.getColor(R.color.background), background)
        assertTrue((0 until picture.width).any { picture.getPixel(it, 60) != background }, "the title is drawn")
    }

    private fun draw(): Bitmap {
        val decor = activity.window.decorView
        decor.measure(
            View.MeasureSpec.makeMeasureSpec(1000, View.MeasureSpec.EXACTLY),
            View.MeasureSpec.makeMeasureSpec(1100, View.MeasureSpec.EXACTLY),
        )
        decor.layout(0, 0, 1000, 1100)
        return Bitmap.createBitmap(1000, 1100, Bitmap.Config.ARGB_8888).also { decor.draw(Canvas(it)) }
    }

    private fun texts(view: View): List<TextView> = when (view) {
        is android.view.ViewGroup -> (0 until view.childCount).flatMap { texts(view.getChildAt(it)) }
        is TextView -> listOf(view).filter { it.isShown }
        else -> emptyList()
    }

    private companion object {
        val RATES = mapOf("world_left" to 29.9, "depth" to 5.0, "imu_left" to 200.1)
        val STATUS = appStatus(
            streams = listOf(
                streamStatus("world_left"),
                streamStatus("depth", dropped = 12),
                streamStatus("eye_nasal_left", "refused", "permission EYE_CAMERA is not granted"),
                streamStatus("imu_left"),
            ),
            permissions = mapOf("com.magicleap.permission.EYE_CAMERA" to false),
            clock = Status.Clock("synchronised", 0, 120_000, 300_000),
            batteryCelsius = 31.5,
        )
    }
}
