using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Ml2Sensors.Editor")]
[assembly: InternalsVisibleTo("Ml2Sensors.OpenXR")]
[assembly: InternalsVisibleTo("Ml2Sensors.RosTcp")]
[assembly: InternalsVisibleTo("Ml2Sensors.Tests")]
