package dev.ml2sensors.app

import android.app.Activity
import android.content.Intent
import android.content.pm.PackageManager
import android.os.Bundle
import android.os.Handler
import android.os.Looper
import android.os.SystemClock
import android.widget.Button
import android.widget.CheckBox
import android.widget.EditText
import dev.ml2sensors.app.control.Command
import dev.ml2sensors.app.screen.RateMeter
import dev.ml2sensors.app.screen.Screen
import kotlin.reflect.KMutableProperty0

/** Shows the status of streaming once a second, and sends the user's commands to the service. */
internal class MainActivity : Activity() {
    private val app get() = application as App
    private val handler = Handler(Looper.getMainLooper())
    private val rateMeter = RateMeter()
    private val declined = LinkedHashSet<String>()
    private val pairingDialog = PairingDialog(this)
    private lateinit var view: ScreenView
    private var ratesHz = emptyMap<String, Double>()

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.main)
        view = ScreenView(findViewById(R.id.main))
        state?.getStringArray(DECLINED)?.let(declined::addAll)
        addListeners()
        if (state == null) pairingDialog.show(intent.dataString) else pairingDialog.restore(state)
    }

    private fun addListeners() {
        findViewById<Button>(R.id.toggle).setOnClickListener {
            StreamingService.send(this, if (screen().isOn) Command.STOP else Command.START)
        }
        findViewById<Button>(R.id.allow).setOnClickListener {
            screen().permissionRequest?.let { requestPermissions(arrayOf(it.permission), 0) }
        }
        findViewById<Button>(R.id.pair).setOnClickListener {
            pairingDialog.show(findViewById<EditText>(R.id.uri).text.toString())
        }
        findViewById<Button>(R.id.reach).setOnClickListener { app.streaming.robot?.reach() }
        bind(R.id.at_boot, app.settings::startAtBoot)
        bind(R.id.pause_when_hot, app.settings::pauseWhenHot)
        bind(R.id.robot, app.settings::showRobot) { app.streaming.showRobot() }
    }

    private fun bind(id: Int, setting: KMutableProperty0<Boolean>, changed: () -> Unit = {}): Unit =
        findViewById<CheckBox>(id).run {
            isChecked = setting.get()
            setOnCheckedChangeListener { _, isChecked ->
                setting.set(isChecked)
                changed()
            }
        }

    override fun onNewIntent(intent: Intent): Unit = pairingDialog.show(intent.dataString)

    override fun onResume() {
        super.onResume()
        // The user may have granted a permission in Android's settings
        if (app.settings.isStreaming) StreamingService.send(this, Command.START)
        refresh()
    }

    override fun onPause() {
        super.onPause()
        handler.removeCallbacksAndMessages(null)
    }

    override fun onDestroy() {
        super.onDestroy()
        pairingDialog.close()
    }

    override fun onSaveInstanceState(state: Bundle) {
        super.onSaveInstanceState(state)
        state.putStringArray(DECLINED, declined.toTypedArray())
        pairingDialog.save(state)
    }

    override fun onRequestPermissionsResult(code: Int, permissions: Array<String>, results: IntArray) {
        declined += permissions.filterIndexed { i, _ -> results[i] != PackageManager.PERMISSION_GRANTED }
        if (PackageManager.PERMISSION_GRANTED in results) StreamingService.send(this, Command.START)
        view.show(screen())
    }

    private fun refresh() {
        ratesHz = rateMeter.update(app.streaming.status().counts, SystemClock.elapsedRealtime())
        view.show(screen())
        handler.postDelayed(::refresh, SECOND_MILLIS)
    }

    private fun screen() = Screen.of(app.streaming.status(), ratesHz, declined)

    private companion object {
        const val DECLINED = "declined"
        const val SECOND_MILLIS = 1_000L
    }
}
