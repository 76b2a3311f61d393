@file:Suppress("ktlint:standard:filename")

package android.hardware.camera2

/** A class of a later Android; Robolectric's stand-in for a camera does not load without it. */
@Suppress("ktlint:standard:class-naming")
internal class `CameraDevice$CameraDeviceSetup`
