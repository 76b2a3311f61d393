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
import dev.ml2sensors.app.screen.Rates
import dev.ml2sensors.app.screen.Screen
import kotlin.reflect.KMutableProperty0

/** Shows how streaming stands, once a second, and takes the user's wishes to the service. */
internal class MainActivity : Activity() {
    private val app get() = application as App
    private val clock = Handler(Looper.getMainLooper())
    private val rates = Rates()
    private val declined = LinkedHashSet<String>()
    private val confirmation = PairingConfirmation(this)
    private lateinit var view: ScreenView
    private var ratesHz = emptyMap<String, Double>()

    override fun onCreate(state: Bundle?) {
        super.onCreate(state)
        setContentView(R.layout.main)
        view = ScreenView(findViewById(R.id.main))
        state?.getStringArray(DECLINED)?.let(declined::addAll)
        listen()
        if (state == null) confirmation.show(intent.dataString) else confirmation.restore(state)
    }

    private fun listen() {
        findViewById<Button>(R.id.toggle).setOnClickListener {
            StreamingService.tell(this, if (screen().isOn) Command.STOP else Command.START)
        }
        findViewById<Button>(R.id.allow).setOnClickListener {
            screen().question?.let { requestPermissions(arrayOf(it.permission), 0) }
        }
        findViewById<Button>(R.id.pair).setOnClickListener {
            confirmation.show(findViewById<EditText>(R.id.uri).text.toString())
        }
        listen(R.id.at_boot, app.choices::atBoot)
        listen(R.id.cool_down, app.choices::coolsDown)
    }

    private fun listen(id: Int, choice: KMutableProperty0<Boolean>): Unit = findViewById<CheckBox>(id).run {
        isChecked = choice.get()
        setOnCheckedChangeListener { _, isChecked -> choice.set(isChecked) }
    }

    override fun onNewIntent(intent: Intent): Unit = confirmation.show(intent.dataString)

    override fun onResume() {
        super.onResume()
        // The user may have allowed something elsewhere
        if (app.choices.streams) StreamingService.tell(this, Command.START)
        tick()
    }

    override fun onPause() {
        super.onPause()
        clock.removeCallbacksAndMessages(null)
    }

    override fun onDestroy() {
        super.onDestroy()
        confirmation.close()
    }

    override fun onSaveInstanceState(state: Bundle) {
        super.onSaveInstanceState(state)
        state.putStringArray(DECLINED, declined.toTypedArray())
        confirmation.save(state)
    }

    override fun onRequestPermissionsResult(code: Int, permissions: Array<String>, results: IntArray) {
        declined += permissions.filterIndexed { i, _ -> results[i] != PackageManager.PERMISSION_GRANTED }
        if (PackageManager.PERMISSION_GRANTED in results) StreamingService.tell(this, Command.START)
        view.show(screen())
    }

    private fun tick() {
        ratesHz = rates.of(app.streaming.status().streams, SystemClock.elapsedRealtime())
        view.show(screen())
        clock.postDelayed(::tick, SECOND_MILLIS)
    }

    private fun screen() = Screen.of(app.streaming.status(), ratesHz, declined)

    private companion object {
        const val DECLINED = "declined"
        const val SECOND_MILLIS = 1_000L
    }
}
