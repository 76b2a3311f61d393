package dev.ml2sensors.app

import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.source.Headset
import dev.ml2sensors.stream.StreamerState
import kotlinx.coroutines.runBlocking
import org.junit.After
import org.junit.Test
import org.junit.runner.RunWith
import org.robolectric.RobolectricTestRunner
import org.robolectric.annotation.Config
import kotlin.test.assertEquals

@RunWith(RobolectricTestRunner::class)
@Config(sdk = [29])
class StreamControllerTest {
    private val paired = PairedApp()

    @Volatile
    private var failure: Error? = null
    private val headset = object : Headset by Ml2Sensors.open(paired.app) {
        override val identity: Headset.Identity
            get() = failure?.let { throw it } ?: Headset.Identity("one", "One")
    }
    private val controller = StreamController(paired.app, paired.app.settings) { headset }

    @After
    fun close() {
        runBlocking { controller.stop() }
        paired.close()
    }

    @Test
    fun afterTheStreamerFailedStartMakesANewOne() = runBlocking {
        failure = NoClassDefFoundError("android/Missing")
        controller.start()
        val failed = StreamerState.Ended("failed: NoClassDefFoundError: android/Missing")
        eventually("the failure") { controller.state.value == failed }
        failure = null
        controller.start()
        paired.session("{}")
        eventually("the new session") { controller.state.value is StreamerState.Connected }
        assertEquals("connected", controller.status().state)
    }
}
