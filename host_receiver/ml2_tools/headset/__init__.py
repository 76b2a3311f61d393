"""Controls the app on the headset over adb."""
