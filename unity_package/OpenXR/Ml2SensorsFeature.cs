using System;
using Ml2Sensors.Interop;
using UnityEngine;
using UnityEngine.XR.OpenXR.Features;
#if UNITY_EDITOR
using UnityEditor;
using UnityEditor.XR.OpenXR.Features;
#endif

namespace Ml2Sensors.OpenXR
{
    /// <summary>
    /// Lets the native library use the app's own OpenXR session, for streams whose backend is openxr, gaze and hands. It
    /// asks for the extensions that they want; those the runtime lacks make their streams refused, nothing else.
    /// </summary>
#if UNITY_EDITOR
    [OpenXRFeature(
        UiName = "ML2 Sensors",
        Desc = "Pixel sensors, gaze and hands for ML2 Sensors.",
        Company = "ML2 Sensors",
        Version = "0.1.0",
        FeatureId = Id,
        BuildTargetGroups = new[] { BuildTargetGroup.Android },
        OpenxrExtensionStrings = Extensions)]
#endif
    public sealed class Ml2SensorsFeature : OpenXRFeature
    {
        /// <summary>By which OpenXR settings find it.</summary>
        public const string Id = "dev.ml2sensors.openxr";

        /// <summary>Those of native/openxr/xr_api.h.</summary>
        public const string Extensions =
            "XR_KHR_convert_timespec_time XR_EXT_future XR_ML_pixel_sensor XR_EXT_eye_gaze_interaction "
            + "XR_EXT_hand_tracking";

        private ulong _instance;

        /// <summary>Called by Unity's OpenXR.</summary>
        protected override bool OnInstanceCreate(ulong xrInstance)
        {
            _instance = xrInstance;
            return base.OnInstanceCreate(xrInstance);
        }

        /// <summary>Called by Unity's OpenXR.</summary>
        protected override unsafe void OnSessionCreate(ulong xrSession)
        {
            if (Application.platform != RuntimePlatform.Android) return;
            // The library must be loaded by Java first, so that it finds the virtual machine.
            using (var java = new AndroidJavaClass("java.lang.System"))
                java.CallStatic("loadLibrary", NativeMethods.Library);
            var openXR = new NativeOpenXR
            {
                StructSize = (uint)sizeof(NativeOpenXR),
                Instance = _instance,
                Session = xrSession,
                GetInstanceProcAddr = xrGetInstanceProcAddr,
            };
            NativeError error = NativeError.Sized();
            NativeResult result = NativeMethods.UseOpenXR(ref openXR, ref error);
            if (result != NativeResult.Ok)
                throw new InvalidOperationException($"ML2 Sensors cannot use OpenXR: {error.Message}");
        }

        /// <summary>Waits for the native threads to leave the session, a second at most.</summary>
        protected override void OnSessionDestroy(ulong xrSession)
        {
            if (Application.platform != RuntimePlatform.Android) return;
            NativeError error = NativeError.Sized();
            NativeResult result = NativeMethods.UseOpenXR(IntPtr.Zero, ref error);
            if (result != NativeResult.Ok) Debug.LogWarning($"ML2 Sensors still uses OpenXR: {error.Message}", this);
        }
    }
}
