using System;
using System.Collections.Generic;

namespace UnityEngine.XR
{
    [Flags]
    public enum InputDeviceCharacteristics : uint
    {
        Controller = 64,
    }

    public struct InputFeatureUsage<T>
    {
    }

    public static class CommonUsages
    {
        public static InputFeatureUsage<bool> triggerButton;
    }

    public struct InputDevice
    {
        public bool TryGetFeatureValue(InputFeatureUsage<bool> usage, out bool value) => value = false;
    }

    public static class InputDevices
    {
        public static void GetDevicesWithCharacteristics(InputDeviceCharacteristics desired, List<InputDevice> found) => found.Clear();
    }
}
