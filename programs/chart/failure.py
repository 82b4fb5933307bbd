# SPDX-License-Identifier: Apache-2.0
"""What ends the program with one line and exit code 2."""


class InputError(Exception):
    """Wrong arguments, scenes or files; the message is one line that names what is wrong."""


class NotApplicable(InputError):
    """A method that is not for this scene; `reason` names what it has that the method cannot do."""

    def __init__(self, message, reason):
        super().__init__(message)
        self.reason = reason
