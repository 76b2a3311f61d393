package dev.ml2sensors.app

import android.view.LayoutInflater
import android.view.View
import android.view.ViewGroup
import android.widget.Button
import android.widget.TextView
import dev.ml2sensors.app.screen.Screen
import dev.ml2sensors.app.screen.StringResource

/** Shows a [Screen] in the views of layout/main.xml. Main thread. */
internal class ScreenView(private val root: View) {
    private val context = root.context
    private val streams: ViewGroup = root.findViewById(R.id.streams)

    fun show(screen: Screen) {
        setText(R.id.title, screen.title.resolve())
        setText(R.id.detail, screen.detail)
        setText(R.id.clock, screen.clock?.resolve())
        setText(R.id.heat, screen.heat.resolve())
        root.findViewById<Button>(R.id.toggle).setText(if (screen.isOn) R.string.stop else R.string.start)
        root.findViewById<View>(R.id.permission_request).visibility = visibility(screen.permissionRequest != null)
        screen.permissionRequest?.let { setText(R.id.reason, context.getString(it.reason, it.streams.joinToString())) }
        root.findViewById<View>(R.id.reach).visibility = visibility(screen.hasRobot)
        show(screen.rows)
    }

    private fun show(rows: List<Screen.Row>) {
        while (streams.childCount > rows.size) streams.removeViewAt(streams.childCount - 1)
        while (streams.childCount < rows.size) LayoutInflater.from(context).inflate(R.layout.stream, streams)
        rows.forEachIndexed { i, row ->
            val view = streams.getChildAt(i)
            view.findViewById<TextView>(R.id.stream).text = row.stream
            view.findViewById<TextView>(R.id.rate).run {
                text = row.text.resolve()
                setTextColor(context.getColor(if (row.isWarning) R.color.bad else R.color.text))
            }
        }
    }

    private fun setText(id: Int, text: String?) {
        root.findViewById<TextView>(id).run {
            this.text = text
            visibility = visibility(!text.isNullOrEmpty())
        }
    }

    private fun visibility(isThere: Boolean) = if (isThere) View.VISIBLE else View.GONE

    private fun StringResource.resolve(): String = context.getString(id, *values.toTypedArray())
}
