using System;

namespace UnityEditor
{
    public enum BuildTargetGroup
    {
        Android = 7,
    }
}

namespace UnityEngine.XR.OpenXR.Features
{
    public abstract class OpenXRFeature : ScriptableObject
    {
        protected static IntPtr xrGetInstanceProcAddr => IntPtr.Zero;

        protected internal virtual bool OnInstanceCreate(ulong xrInstance) => true;

        protected internal virtual void OnSessionCreate(ulong xrSession)
        {
        }

        protected internal virtual void OnSessionDestroy(ulong xrSession)
        {
        }
    }
}

namespace UnityEditor.XR.OpenXR.Features
{
    public sealed class OpenXRFeatureAttribute : Attribute
    {
        public string UiName;
        public string Desc;
        public string Company;
        public string Version;
        public string FeatureId;
        public string OpenxrExtensionStrings;
        public BuildTargetGroup[] BuildTargetGroups;
    }
}
