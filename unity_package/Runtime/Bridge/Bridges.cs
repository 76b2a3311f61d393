using System;
using UnityEngine;

namespace Ml2Sensors.Bridge
{
    internal static class Bridges
    {
        public static IMl2Bridge Open(Action<string> changed)
        {
            if (Application.platform == RuntimePlatform.Android) return new AndroidBridge(changed);
            return new NullBridge(Application.platform.ToString());
        }
    }
}
