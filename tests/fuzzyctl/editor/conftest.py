"""The fixture of conversations with one server."""

from tests.fuzzyctl.editor.wire import with_shared_server

__all__ = ["with_shared_server"]
