using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Xml;
using System.Xml.Linq;
using UnityEditor.Android;

namespace Ml2Sensors.Editor
{
    /// <summary>Edits the text of an AndroidManifest.xml. Functions are pure.</summary>
    internal static class AndroidManifest
    {
        private static readonly XNamespace Android = "http://schemas.android.com/apk/res/android";
        private static readonly XNamespace Tools = "http://schemas.android.com/tools";

        /// <summary>Adds the permissions that the manifest lacks. Returns the text unchanged if it has them all.</summary>
        /// <exception cref="FormatException">The text is not an Android manifest, or it removes one of the permissions.</exception>
        public static string WithPermissions(string manifest, IEnumerable<string> permissions)
        {
            XDocument document = Parse(manifest);
            var declared = document.Root.Elements("uses-permission").ToLookup(element => (string)element.Attribute(Android + "name"));
            string[] missing = permissions.Where(permission => !IsDeclared(declared[permission], permission)).Distinct().ToArray();
            if (missing.Length == 0) return manifest;
            XElement application = document.Root.Element("application");
            foreach (string permission in missing)
            {
                var element = new XElement("uses-permission", new XAttribute(Android + "name", permission));
                if (application == null) document.Root.Add("  ", element, "\n");
                else application.AddBeforeSelf(element, "\n  ");
            }
            return Text(document);
        }

        private static bool IsDeclared(IEnumerable<XElement> elements, string permission)
        {
            foreach (XElement element in elements)
            {
                if ((string)element.Attribute(Tools + "node") == "remove")
                    throw new FormatException($"The manifest removes {permission}, which the chosen streams need. Delete that uses-permission element.");
                return true;
            }
            return false;
        }

        private static XDocument Parse(string manifest)
        {
            XDocument document;
            try
            {
                document = XDocument.Parse(manifest, LoadOptions.PreserveWhitespace);
            }
            catch (XmlException e)
            {
                throw new FormatException($"Expected XML in AndroidManifest.xml, found: {e.Message}", e);
            }
            if (document.Root.Name == "manifest" && document.Root.GetPrefixOfNamespace(Android) != null) return document;
            throw new FormatException($"Expected <manifest> with the namespace {Android}, found <{document.Root.Name}>.");
        }

        private static string Text(XDocument document)
        {
            string body = document.ToString(SaveOptions.DisableFormatting);
            return document.Declaration == null ? body : $"{document.Declaration}\n{body}";
        }
    }

    /// <summary>Adds the permissions of the chosen streams to the manifest that Unity generates.</summary>
    internal sealed class ManifestPermissions : IPostGenerateGradleAndroidProject
    {
        public int callbackOrder => 0;

        /// <param name="path">The folder of the module unityLibrary.</param>
        public void OnPostGenerateGradleAndroidProject(string path)
        {
            Ml2SensorConfig config = Ml2SensorSettings.instance.Config;
            if (config == null) return;
            string file = Path.Combine(path, "src", "main", "AndroidManifest.xml");
            string before = File.ReadAllText(file);
            string after = AndroidManifest.WithPermissions(before, config.Permissions);
            if (after != before) File.WriteAllText(file, after);
        }
    }
}
