"""What the package raises."""


class GearmeshError(RuntimeError):
    """Something was refused or is missing; the text says what, and what would be right."""


class CommandError(GearmeshError):
    """The command `gearmesh` refused its input; the text is its message."""


class GearPairError(GearmeshError):
    """A call was refused; the text says why, from the FMU's log where the FMU refused it."""
