"""The .meta files of the Unity package: Unity knows assets by the GUIDs in them.

A GUID is made of the asset's path, so it stays as long as that does. Unity ignores what begins
with a dot or ends in ~; what is in Samples~ is copied into projects, with its metas.
"""

import hashlib
from collections.abc import Iterator
from pathlib import Path

PACKAGE = "dev.ml2sensors.unity"

FOLDER = """folderAsset: yes
DefaultImporter:
  externalObjects: {}
"""
SCRIPT = """MonoImporter:
  externalObjects: {}
  serializedVersion: 2
  defaultReferences: []
  executionOrder: 0
  icon: {instanceID: 0}
"""
ANDROID_LIBRARY = """PluginImporter:
  externalObjects: {}
  serializedVersion: 2
  iconMap: {}
  executionOrder: {}
  defineConstraints: []
  isPreloaded: 0
  isOverridable: 0
  isExplicitlyReferenced: 0
  validateReferences: 1
  platformData:
  - first:
      Android: Android
    second:
      enabled: 1
      settings: {}
  - first:
      Any:
    second:
      enabled: 0
      settings: {}
  - first:
      Editor: Editor
    second:
      enabled: 0
      settings:
        DefaultValueInitialized: true
"""
IMPORTERS = {
    ".cs": SCRIPT,
    ".aar": ANDROID_LIBRARY,
    ".asmdef": "AssemblyDefinitionImporter:\n  externalObjects: {}\n",
    ".md": "TextScriptImporter:\n  externalObjects: {}\n",
    "package.json": "PackageManifestImporter:\n  externalObjects: {}\n",
}
IMPORTERS[".shader"] = (
    "ShaderImporter:\n  externalObjects: {}\n  defaultTextures: []\n  nonModifiableTextures: []\n"
)
IMPORTERS[".mat"] = "NativeFormatImporter:\n  externalObjects: {}\n  mainObjectFileID: 2100000\n"
DEFAULT = "DefaultImporter:\n  externalObjects: {}\n"
END = "  userData:\n  assetBundleName:\n  assetBundleVariant:\n"


def unity_metas(package: Path) -> Iterator[tuple[Path, str]]:
    """Every meta that the package should have, with its text."""
    for asset in assets(package):
        name = f"{PACKAGE}/{asset.relative_to(package).as_posix()}"
        guid = hashlib.md5(name.encode()).hexdigest()
        text = f"fileFormatVersion: 2\nguid: {guid}\n{_importer(asset)}{END}"
        yield asset.with_name(asset.name + ".meta"), text


def assets(folder: Path) -> Iterator[Path]:
    """All that Unity imports of the package."""
    for entry in sorted(folder.iterdir()):
        if entry.name == "Samples~":
            yield from assets(entry)
        elif not entry.name.startswith(".") and not entry.name.endswith(("~", ".meta")):
            yield entry
            if entry.is_dir():
                yield from assets(entry)


def _importer(asset: Path) -> str:
    if asset.is_dir():
        return FOLDER
    return IMPORTERS.get(asset.name) or IMPORTERS.get(asset.suffix) or DEFAULT
