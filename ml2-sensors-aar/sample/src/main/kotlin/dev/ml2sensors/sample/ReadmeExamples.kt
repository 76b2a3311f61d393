// The examples in the README of the library. tests/aar compiles this file and compares both texts.

package dev.ml2sensors.sample

import android.content.Context
import android.os.SystemClock
import dev.ml2sensors.android.Ml2Sensors
import dev.ml2sensors.cdr.Cdr
import dev.ml2sensors.message.Header
import dev.ml2sensors.message.Pose
import dev.ml2sensors.message.PoseStamped
import dev.ml2sensors.message.Time
import dev.ml2sensors.message.Transform
import dev.ml2sensors.ros.Keep
import dev.ml2sensors.source.Headset
import dev.ml2sensors.source.ImageSample
import dev.ml2sensors.source.defaultValues
import dev.ml2sensors.stream.Ml2Streamer
import dev.ml2sensors.table.StreamTable
import kotlinx.coroutines.CoroutineScope
import kotlinx.coroutines.coroutineScope
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.launch
import java.nio.ByteBuffer

fun stream(context: Context, scope: CoroutineScope, uri: String) {
    val headset = Ml2Sensors.open(context) // all sensors of the device; close() it in the end
    scope.launch {
        Ml2Sensors.pair(context, uri) // once: the URI that `ml2-receiver pair` shows
        val streamer = Ml2Sensors.connect(context, headset)
        streamer.start()
        launch { streamer.state.collect { println(it) } } // Connecting(reason), Connected(receiverName), Ended(reason)
        launch { streamer.streams.collect { println(it) } } // each: Running(values), Waiting(reason), Refused(reason)
    }
}

fun publish(streamer: Ml2Streamer, pose: Pose, captureNanos: Long) {
    val anchor = streamer.publisher("anchor", "geometry_msgs/msg/PoseStamped") // custom/anchor
    val stampNanos = streamer.stampNanos(captureNanos) // null while ROS time is not known
    if (stampNanos != null) {
        val message = PoseStamped(Header(Time.ofNanos(stampNanos), "magicleap_world"), pose)
        anchor.publish(ByteBuffer.wrap(Cdr.encodeToByteArray(PoseStamped.serializer(), message)), captureNanos)
    }
}

suspend fun subscribe(streamer: Ml2Streamer, show: (Pose, Long?) -> Unit) {
    streamer.subscribe("/goal_pose", PoseStamped.serializer(), Keep.Latest).collect { received ->
        show(received.message.pose, received.publishedNanos)
    }
}

suspend fun steerArm(streamer: Ml2Streamer, targets: Flow<Pose>, show: (Pose) -> Unit) = coroutineScope {
    launch {
        streamer.subscribe("/tag_pose", PoseStamped.serializer(), Keep.Latest).collect { show(it.message.pose) }
    }
    val publisher = streamer.publisher("/target_pose", "geometry_msgs/msg/PoseStamped")
    targets.collect { target ->
        val nowNanos = SystemClock.elapsedRealtimeNanos()
        val stampNanos = streamer.stampNanos(nowNanos) ?: return@collect // ROS time is not known
        val message = PoseStamped(Header(Time.ofNanos(stampNanos), "magicleap_world"), target)
        publisher.publish(ByteBuffer.wrap(Cdr.encodeToByteArray(PoseStamped.serializer(), message)), nowNanos)
    }
}

suspend fun collect(headset: Headset, process: (ByteBuffer, Long, Transform?) -> Unit) {
    val stream = StreamTable.worldLeft
    headset.samples(stream, stream.defaultValues()).collect { sample ->
        if (sample is ImageSample) process(sample.pixels, sample.captureNanos, sample.pose)
    }
}
