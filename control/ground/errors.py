"""The exceptions users meet. Each message is one sentence: what, where, and what is allowed."""

LONGEST = 600  # characters of a sentence: what was given may be a whole file


class SimsatError(Exception):
    """Root of every error raised on purpose; its text is one printable line, whatever it quotes."""

    def __str__(self) -> str:
        return one_line(super().__str__())


def one_line(text: str) -> str:
    """The text on one line, what doesn't print (terminals obey it) written out, its middle left out
    if it is long."""
    text = " ".join(text.splitlines())
    if len(text) > LONGEST:
        half = LONGEST // 2
        text = f"{text[:half]} ... {text[-half:]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


class ModelError(SimsatError):
    """A spacecraft file that can't be read, or that MuJoCo would fly wrongly.

    Its first argument is the sentence, any others are faults, which get a line each.
    """

    def __str__(self) -> str:
        return "\n  - ".join(one_line(str(argument)) for argument in self.args)


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
