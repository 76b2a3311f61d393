using System;
using System.Collections.Generic;
using UnityEngine;
using UnityEngine.XR;

namespace Ml2Sensors.Samples
{
    /// <summary>
    /// Pairs with the URI that opened the app, such as by adb. The wearer must pull the trigger first, since any app on the
    /// headset can send a URI.
    /// </summary>
    public sealed class PairingLink : MonoBehaviour
    {
        [SerializeField] private Ml2SensorStreamer _streamer;
        [SerializeField] private TextMesh _question;

        private readonly List<InputDevice> _controllers = new List<InputDevice>();
        private string _uri;

        private void OnEnable()
        {
            Application.deepLinkActivated += Ask;
            if (!string.IsNullOrEmpty(Application.absoluteURL)) Ask(Application.absoluteURL);
        }

        private void OnDisable() => Application.deepLinkActivated -= Ask;

        private void Update()
        {
            if (_uri == null || !IsTriggerPulled()) return;
            _streamer.Pair(_uri);
            _uri = null;
            _question.text = "";
        }

        private void Ask(string uri)
        {
            if (!uri.StartsWith("ml2s://", StringComparison.Ordinal)) return;
            _uri = uri;
            _question.text = $"Pair with {uri.Split('?')[0]}? Pull the trigger.";
        }

        private bool IsTriggerPulled()
        {
            InputDevices.GetDevicesWithCharacteristics(InputDeviceCharacteristics.Controller, _controllers);
            foreach (InputDevice controller in _controllers)
                if (controller.TryGetFeatureValue(CommonUsages.triggerButton, out bool isPulled) && isPulled) return true;
            return false;
        }
    }
}
