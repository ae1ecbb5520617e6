"""Invalid messages: a request among them has an answer, and the log has a line, no traceback."""

from __future__ import annotations

import json
import logging
from typing import Any

from pygls.exceptions import JsonRpcException, JsonRpcInternalError, JsonRpcInvalidParams
from pygls.protocol import LanguageServerProtocol


class RefusedError(JsonRpcException):
    """A request that is right and cannot be fulfilled, such as a name that is taken; the message is for the user."""

    #: RequestFailed of the protocol.
    CODE = -32803


class Protocol(LanguageServerProtocol):
    """Answers requests with invalid parameters, such as negative lines, with an error."""

    def structure_message(self, data: dict[str, Any]) -> Any:
        """Return the message of some data."""
        try:
            return super().structure_message(data)
        except JsonRpcException as error:
            reason = str(error.__cause__ or error).strip().split("\n")[0]
            mistake = JsonRpcInvalidParams(f"these are not parameters of '{data.get('method', '')}': {reason}")
            if "id" in data and "method" in data:
                self._send_response(data["id"], error=mistake.to_response_error())
            raise mistake from None


def is_of_client(error: BaseException | None) -> bool:
    """Whether an error is a mistake in a message, not in the server."""
    if isinstance(error, JsonRpcInternalError):
        return False
    return isinstance(error, JsonRpcException | json.JSONDecodeError | UnicodeDecodeError)


def log_in_lines() -> None:
    """Write mistakes of clients, which the answer names, as one line of the log; do not log refused messages."""
    for name in ("pygls.protocol.json_rpc", "pygls.server"):
        logging.getLogger(name).addFilter(_in_a_line)


def _in_a_line(record: logging.LogRecord) -> bool:
    error = record.exc_info[1] if record.exc_info else None
    if isinstance(error, RefusedError):
        return False
    if is_of_client(error):
        record.msg, record.args, record.exc_info = f"{record.getMessage()}: {error}", (), None
    elif isinstance(record.args, tuple) and record.args and "Traceback" in str(record.args[-1]):
        record.args = (*record.args[:-1], str(record.args[-1]).strip().rsplit("\n", 1)[-1])
    return True
