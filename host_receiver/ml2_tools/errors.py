"""The exceptions that tools raise for reasons outside their own code.

ReceiverError
├── MessagesError     a message type without a description, or one that has no class
├── ExportError       nothing to export, or not in that format
├── LatencyError      nothing to measure, or no plot of it
├── EvaluationError   a recording or images that give no trajectory
├── PlaybackError     a receiver that recordings cannot be played to
└── AdbError          adb, or the headset's app
"""

from ml2_receiver.errors import ReceiverError


class MessagesError(ReceiverError):
    """A message type has no description here, or no class can be made of it."""


class ExportError(ReceiverError):
    """There is nothing to export, or the format cannot express it."""


class LatencyError(ReceiverError):
    """There is nothing to measure, or it cannot be plotted."""


class EvaluationError(ReceiverError):
    """There is no trajectory to evaluate, or a package that evaluation needs is missing."""


class PlaybackError(ReceiverError):
    """There is no receiver to play to, or it ended the session."""


class AdbError(ReceiverError):
    """adb is missing or reaches no headset, or the app there did not carry out a command."""
