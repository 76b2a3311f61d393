"""The app on the headset, commanded over adb."""
