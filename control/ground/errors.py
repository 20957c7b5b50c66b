"""The exceptions users meet. Each message is one sentence: what, where, and what is allowed."""


class SimsatError(Exception):
    """Root of every error raised on purpose."""


class ModelError(SimsatError):
    """A spacecraft file that can't be read, or that MuJoCo would fly wrongly."""


class SettingsError(SimsatError):
    """A setting outside its range, or two settings that contradict each other."""


class OutputError(SimsatError):
    """An output folder or file that exists already or can't be written."""


class NetworkError(SimsatError):
    """A network file that is missing, corrupt, or made for another spacecraft."""


class ForeignNetworkError(NetworkError):
    """A network file made for another spacecraft or another control period."""


class DivergedError(SimsatError):
    """The simulation left the finite numbers; the message says when and in which variable."""


class PluginError(SimsatError):
    """Code of the user's own (a controller, torque, network, metric) that failed."""
