using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Ml2Sensors.Tests")]
