@file:Suppress("ktlint:standard:filename")

package android.hardware.camera2

/** Of a later Android; Robolectric's stand-in for a camera does not load without. */
@Suppress("ktlint:standard:class-naming")
internal class `CameraDevice$CameraDeviceSetup`
