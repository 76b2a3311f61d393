using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;

namespace UnityEngine
{
    public class Object
    {
        public string name { get; set; } = "";

        public bool IsDestroyed { get; private set; }

        /// <summary>A destroyed object is equal to null.</summary>
        public static bool operator ==(Object a, Object b) => ReferenceEquals(a, b) || (!a && !b);

        public static bool operator !=(Object a, Object b) => !(a == b);

        public static implicit operator bool(Object value) => !ReferenceEquals(value, null) && !value.IsDestroyed;

        public override bool Equals(object other) => ReferenceEquals(this, other);

        public override int GetHashCode() => base.GetHashCode();

        public static void Destroy(Object target) => target.IsDestroyed = true;

        public static T Instantiate<T>(T original, Transform parent) where T : Object => original;

        public static void DestroyImmediate(Object target) => Destroy(target);

        public static T FindFirstObjectByType<T>() where T : Component => GameObject.Find<T>();
    }

    public class TextMesh : Component
    {
        public string text { get; set; }

        public bool richText { get; set; } = true;
    }

    public class ScriptableObject : Object
    {
        public static T CreateInstance<T>() where T : ScriptableObject, new() => new T();
    }

    public class Component : Object
    {
        public GameObject gameObject { get; internal set; }

        public Transform transform { get; } = new Transform();

        public T GetComponent<T>() where T : Component => gameObject.GetComponent<T>();
    }

    public class Transform : Object
    {
        public Vector3 position { get; set; }
        public Vector3 localPosition { get; set; }
        public Quaternion rotation { get; set; }

        public void SetPositionAndRotation(Vector3 position, Quaternion rotation)
        {
            this.position = position;
            this.rotation = rotation;
        }
    }

    public class Behaviour : Component
    {
        private bool _isEnabled;

        public bool enabled
        {
            get => _isEnabled;
            set
            {
                if (_isEnabled == value) return;
                _isEnabled = value;
                this.Send(value ? "OnEnable" : "OnDisable");
            }
        }
    }

    public class MonoBehaviour : Behaviour
    {
    }

    public sealed class GameObject : Object
    {
        private static readonly List<GameObject> Loaded = new List<GameObject>();
        private readonly List<Component> _components = new List<Component>();

        public GameObject(string name)
        {
            this.name = name;
            Loaded.Add(this);
        }

        public Transform transform { get; } = new Transform();

        public static void UnloadAll()
        {
            foreach (Component component in Loaded.SelectMany(it => it._components)) Destroy(component);
            Loaded.Clear();
        }

        internal static T Find<T>() where T : Component =>
            Loaded.Select(it => it.GetComponent<T>()).FirstOrDefault(it => it != null);

        public void SetActive(bool value)
        {
        }

        /// <summary>As Unity's for an inactive object: nothing is enabled until someone does it.</summary>
        public T AddComponent<T>() where T : Component, new()
        {
            foreach (RequireComponent it in typeof(T).GetCustomAttributes(typeof(RequireComponent), false))
                if (!_components.Exists(it.Type.IsInstanceOfType)) Add((Component)Activator.CreateInstance(it.Type));
            return Add(new T());
        }

        private T Add<T>(T component) where T : Component
        {
            component.gameObject = this;
            _components.Add(component);
            return component;
        }

        public T GetComponent<T>() where T : Component => _components.Find(component => component is T) as T;
    }

    /// <summary>Unity's messages, which it finds by their names.</summary>
    public static class Messages
    {
        public static void Send(this Component target, string message, params object[] arguments)
        {
            MethodInfo method = target.GetType().GetMethod(message, BindingFlags.Instance | BindingFlags.NonPublic);
            try
            {
                method?.Invoke(target, arguments);
            }
            catch (TargetInvocationException e)
            {
                System.Runtime.ExceptionServices.ExceptionDispatchInfo.Capture(e.InnerException).Throw();
            }
        }

        /// <summary>For loops that must not allocate.</summary>
        public static Action Bind(this Component target, string message) =>
            (Action)Delegate.CreateDelegate(typeof(Action), target, message);
    }
}
