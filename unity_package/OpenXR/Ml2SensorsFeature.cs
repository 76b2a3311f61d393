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
    /// Lets the native library use the app's OpenXR session for markers and streams whose backend is openxr. It requests
    /// the extensions that they need. If the runtime lacks an extension, only the streams that need it are refused.
    /// </summary>
#if UNITY_EDITOR
    [OpenXRFeature(
        UiName = "ML2 Sensors",
        Desc = "Pixel sensors, gaze, hands and markers for ML2 Sensors.",
        Company = "ML2 Sensors",
        Version = "0.1.0",
        FeatureId = Id,
        BuildTargetGroups = new[] { BuildTargetGroup.Android },
        OpenxrExtensionStrings = Extensions)]
#endif
    public sealed class Ml2SensorsFeature : OpenXRFeature
    {
        /// <summary>The id of the feature in the OpenXR settings.</summary>
        public const string Id = "dev.ml2sensors.openxr";

        /// <summary>The extensions in native/openxr/xr_api.h.</summary>
        public const string Extensions =
            "XR_KHR_convert_timespec_time XR_EXT_future XR_ML_pixel_sensor XR_EXT_eye_gaze_interaction "
            + "XR_EXT_hand_tracking XR_ML_marker_understanding";

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
            // Java must load the library first, so that the library gets the Java virtual machine. It finds the library by
            // the class loader of the caller, which has to be a class of the app: GameActivity calls from a native thread
            using (var facade = new AndroidJavaClass("dev.ml2sensors.unity.Ml2Unity")) facade.CallStatic("loadLibrary");
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

        /// <summary>Waits at most a second for the native threads to leave the session.</summary>
        protected override void OnSessionDestroy(ulong xrSession)
        {
            if (Application.platform != RuntimePlatform.Android) return;
            NativeError error = NativeError.Sized();
            NativeResult result = NativeMethods.UseOpenXR(IntPtr.Zero, ref error);
            if (result != NativeResult.Ok) Debug.LogWarning($"ML2 Sensors still uses OpenXR: {error.Message}", this);
        }
    }
}
