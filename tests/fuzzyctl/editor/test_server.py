"""The language server over the wire: a client of pygls starts it as an editor does."""

import asyncio
from pathlib import Path

import pytest
from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException

from tests.fuzzyctl.editor.marked import LOOP
from tests.fuzzyctl.editor.marked import SYSTEM as BASE
from tests.fuzzyctl.editor.wire import (
    SECONDS,
    changed,
    opened,
    position,
    with_server,
)

SYSTEM = BASE + 'allow FZ219 "kept for later"\n'


def applied(text, edits):
    lines = text.split("\n")
    for e in sorted(edits, key=lambda e: (e.range.start.line, e.range.start.character), reverse=True):
        start, end = e.range.start, e.range.end
        head, tail = lines[start.line][: start.character], lines[end.line][end.character :]
        lines[start.line : end.line + 1] = (head + e.new_text + tail).split("\n")
    return "\n".join(lines)


def test_a_conversation(with_shared_server):
    async def talk(client, capabilities):
        assert capabilities.rename_provider
        document = opened(client, SYSTEM)
        assert not (await client.diagnostics()).diagnostics
        wrong = SYSTEM.replace("large  large", "large  lagre")
        changed(client, document, 2, wrong)
        (mistake,) = (await client.diagnostics(2)).diagnostics
        assert (mistake.code, mistake.severity) == ("FZ203", lsp.DiagnosticSeverity.Error)
        assert (mistake.range.start.line, mistake.range.start.character) == (16, 23)
        actions = await client.text_document_code_action_async(
            lsp.CodeActionParams(document, mistake.range, lsp.CodeActionContext([mistake]))
        )
        (edits,) = actions[0].edit.changes.values()
        assert applied(wrong, edits) == SYSTEM
        changed(client, document, 3, SYSTEM)
        at = position(SYSTEM, "poor |")
        here = {"text_document": document, "position": at}
        found = await client.text_document_definition_async(lsp.DefinitionParams(**here))
        assert found.range.start == position(SYSTEM, "poor = ")
        renamed = await client.text_document_rename_async(lsp.RenameParams(**here, new_name="awful"))
        (edits,) = renamed.changes.values()
        assert applied(SYSTEM, edits) == SYSTEM.replace("poor", "awful")
        shown = await client.text_document_hover_async(lsp.HoverParams(**here))
        assert "ramp(10, 0)" in shown.contents.value
        proposed = await client.text_document_completion_async(
            lsp.CompletionParams(document, position(SYSTEM, "poor |", 8))
        )
        assert [i.label for i in proposed.items] == ["small", "large"]
        symbols = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(document))
        assert [s.name for s in symbols] == ["tip"]
        edits = await client.text_document_formatting_async(
            lsp.DocumentFormattingParams(document, lsp.FormattingOptions(2, True))
        )
        assert "hedge hardly(d) = d^3" in applied(SYSTEM, edits)
        client.text_document_did_close(lsp.DidCloseTextDocumentParams(document))
        assert (await client.diagnostics()).uri == document.uri

    with_shared_server(talk)


def test_a_refuted_guarantee_lights_up_and_a_burst_gives_one_proof(with_shared_server):
    async def talk(client, _):
        document = opened(client, SYSTEM)
        for version in range(2, 62):
            changed(client, document, version, SYSTEM.replace("tip >= 0", f"tip >= {version}"))
        seen = []
        while not seen or "FZ4" not in str([d.code for d in seen[-1].diagnostics]):
            seen.append(await client.diagnostics())
        proofs = [p for p in seen if p.diagnostics]
        assert [p.version for p in proofs] == [61]
        assert "tip >= 61" in proofs[0].diagnostics[0].message

    with_shared_server(talk)


def test_units_of_the_client(with_shared_server):
    text = 'system t "🙂🙂" \nparam a = 1\n# 🙂\n' + "input x in [0, a]\n  terms p q  # 🙂 p\nlet y = x * a\n"

    async def talk(client, _):
        document = opened(client, text)
        await client.diagnostics()
        found = await client.text_document_references_async(
            lsp.ReferenceParams(
                context=lsp.ReferenceContext(True), text_document=document, position=position(text, "a = 1")
            )
        )
        assert [(p.range.start.line, p.range.start.character) for p in found] == [(1, 6), (3, 15), (5, 12)]

    with_shared_server(talk)


def test_files_that_are_used(tmp_path, with_shared_server):
    (tmp_path / "shared.fz").write_text("input service in [0, 10]\n  terms poor good\n")
    text = 'system t\ndefuzzifier center_average\nuse "shared.fz"\noutput tip in [0, 1] else 0\n'
    text += "  terms small=0 large=1\nif service is poor then tip is small\n"
    path = tmp_path / "a.fz"
    path.write_text(text)

    async def talk(client, _):
        document = opened(client, text, path.as_uri())
        assert [d for d in (await client.diagnostics()).diagnostics if d.severity == 1] == []
        at = {"text_document": document, "position": position(text, "poor")}
        found = await client.text_document_definition_async(lsp.DefinitionParams(**at))
        assert (found.uri, found.range.start.line) == ((tmp_path / "shared.fz").as_uri(), 1)
        shared = opened(client, (tmp_path / "shared.fz").read_text(), (tmp_path / "shared.fz").as_uri())
        declared = {"text_document": shared, "position": lsp.Position(1, 8)}
        context = lsp.ReferenceContext(True)
        uses = await client.text_document_references_async(lsp.ReferenceParams(context=context, **declared))
        assert [u.uri for u in uses] == [shared.uri, document.uri]
        renamed = await client.text_document_rename_async(lsp.RenameParams(new_name="awful", **declared))
        (edit,) = renamed.changes[document.uri]
        assert (edit.new_text, edit.range) == ("awful", uses[1].range)
        client.text_document_did_close(lsp.DidCloseTextDocumentParams(shared))
        (tmp_path / "shared.fz").unlink()
        changed(client, document, 2, text + "\n")
        assert (await client.diagnostics(2)).diagnostics[0].code == "FZ218"

    with_shared_server(talk)


def test_a_preview(with_shared_server):
    text = "system t\ndefuzzifier center_average\ninput x in [0, 1]\n  terms a b\n"
    text += "output y in [0, 1]\n  terms p q\ntable y = x\n    a  b\n  | p  q\n"

    async def talk(client, _):
        document = opened(client, text)

        async def asked(**more):
            place = {"line": 1, "character": 2}
            params = {"textDocument": {"uri": document.uri}, "position": place, **more}
            return await client.protocol.send_request_async("fuzzyctl/preview", params)

        found = await asked(point=[{"name": "x", "value": 0.8}])
        assert (found.title, found.message) == ("t: y", "")
        assert (found.rule.start.line, found.rule.start.character) == (8, 7)
        assert found.surface.startswith("<?xml")
        assert [(i.name, i.value) for i in found.inputs] == [("x", 0.8)]
        assert (await asked(point=None)).rules == (await asked()).rules == ""
        cell = await asked(position={"line": 8, "character": 7}, pictures=False)
        assert (cell.surface, cell.region.text) == ("", "if x is b then y is q")
        assert (cell.region.rule.start.line, cell.region.rule.start.character) == (8, 7)
        assert ([(v.name, v.value) for v in cell.region.point], cell.region.inputs[0].support) == ([("x", 1)], [0, 1])
        back = await asked(point=[{"name": "x", "value": 1}], pictures=False)
        assert (back.rule, back.strength) == (cell.region.rule, 1)
        for wrong in ({"point": 3}, {"point": [{"name": "x"}]}, {"position": None}, {"textDocument": 1}):
            with pytest.raises(JsonRpcException, match="fuzzyctl/preview takes"):
                await asked(**wrong)
        changed(client, document, 2, text.replace("p  q\n", "p  qq\n"))
        assert (await asked()).message == "system 't' has mistakes"

    with_shared_server(talk)


def test_loops_have_names_too(with_shared_server):
    async def talk(client, _):
        document = opened(client, LOOP)
        await client.diagnostics()
        at = {"text_document": document, "position": position(LOOP, "surface(e")}
        assert (await client.text_document_definition_async(lsp.DefinitionParams(**at))).range.start.line == 0

    with_shared_server(talk)


REFRESHING = lsp.ClientCapabilities(
    text_document=lsp.TextDocumentClientCapabilities(
        completion=lsp.CompletionClientCapabilities(
            completion_item=lsp.ClientCompletionItemOptions(snippet_support=True)
        ),
        diagnostic=lsp.DiagnosticClientCapabilities(),
        publish_diagnostics=lsp.PublishDiagnosticsClientCapabilities(related_information=True),
    ),
    workspace=lsp.WorkspaceClientCapabilities(
        diagnostics=lsp.DiagnosticWorkspaceClientCapabilities(refresh_support=True),
        code_lens=lsp.CodeLensWorkspaceClientCapabilities(refresh_support=True),
        inlay_hint=lsp.InlayHintWorkspaceClientCapabilities(refresh_support=True),
    ),
)


def whole(text):
    return lsp.Range(lsp.Position(0, 0), lsp.Position(text.count("\n") + 9, 0))


async def formats(client, document, text):
    """A row is aligned when its line ends, and a range on request."""
    loose = text.replace("good | small  large", "good |small large")
    changed(client, document, 2, loose)
    row = loose[: loose.index("good |")].count("\n")
    edits = await client.text_document_on_type_formatting_async(
        lsp.DocumentOnTypeFormattingParams(document, lsp.Position(row + 1, 0), "\n", lsp.FormattingOptions(2, True))
    )
    assert applied(loose, edits).count("  good |  small  large  large\n") == 1
    edits = await client.text_document_range_formatting_async(
        lsp.DocumentRangeFormattingParams(document, whole(loose), lsp.FormattingOptions(2, True))
    )
    assert "hedge hardly(d) = d^3" in applied(loose, edits)


def test_a_client_that_asks_for_diagnostics_hears_when_they_change():
    text = SYSTEM + "require tip <= 19\nparam wide = most + 1\n"

    async def talk(client, capabilities):
        refreshed = asyncio.Queue()
        for method in (
            lsp.WORKSPACE_DIAGNOSTIC_REFRESH,
            lsp.WORKSPACE_CODE_LENS_REFRESH,
            lsp.WORKSPACE_INLAY_HINT_REFRESH,
        ):
            client.feature(method)(lambda *_, method=method: refreshed.put_nowait(method))
        shown = []
        client.feature(lsp.WINDOW_SHOW_MESSAGE)(lambda params: shown.append(params.message))
        document = opened(client, text)
        assert {await asyncio.wait_for(refreshed.get(), SECONDS) for _ in range(3)} == {
            "workspace/diagnostic/refresh",
            "workspace/codeLens/refresh",
            "workspace/inlayHint/refresh",
        }
        assert client.published.empty()
        report = await client.text_document_diagnostic_async(lsp.DocumentDiagnosticParams(document))
        refuted = next(d for d in report.items if d.code == "FZ402")
        assert refuted.related_information[0].message.startswith("counterexample: service=")
        point = refuted.related_information[0].message.removeprefix("counterexample: ")
        assert refuted.data == {"why": point}
        lenses = await client.text_document_code_lens_async(lsp.CodeLensParams(document))
        assert [x.command.title[:9] for x in lenses] == ["surface", "prove", "✓ proved", "✗ refuted"]
        given = lenses[-1].command
        quiet, done = [
            await client.workspace_execute_command_async(lsp.ExecuteCommandParams(given.command, arguments=arguments))
            for arguments in ([*given.arguments, True], given.arguments)
        ]
        assert quiet == done
        assert (done["exit"], "tip" in done["text"], shown) == (0, True, [done["text"]])
        hints = await client.text_document_inlay_hint_async(lsp.InlayHintParams(document, whole(text)))
        assert [h.label for h in hints] == ["@0", "@5", "@10", "proved [0, 20]", "= 21"]
        options = capabilities.semantic_tokens_provider
        legend = options.legend
        found = await client.text_document_semantic_tokens_full_async(lsp.SemanticTokensParams(document))
        assert [legend.token_types[k] for k in found.data[3:15:5]] == ["keyword", "namespace", "string"]
        line = lsp.Range(lsp.Position(2, 0), lsp.Position(2, 15))
        part = await client.text_document_semantic_tokens_range_async(lsp.SemanticTokensRangeParams(document, line))
        assert list(part.data) == [2, 0, 5, legend.token_types.index("keyword"), 0, 0, 6, 4, 4, 3, 0, 7, 2, 10, 0]
        proposed = await client.text_document_completion_async(
            lsp.CompletionParams(document, lsp.Position(text.count("\n"), 0))
        )
        require = next(i for i in proposed.items if i.label == "require")
        assert (require.text_edit.new_text, require.insert_text_format) == ("require ${1:output} >= ${2:0}", 2)
        await formats(client, document, text)

    with_server(talk, REFRESHING)


def test_texts_that_are_not_saved_are_used_and_files_may_vanish(tmp_path, with_shared_server):
    shared = "input service in [0, 10]\n  terms poor good\n"
    text = 'system t\ndefuzzifier center_average\nuse "shared.fz"\noutput tip in [0, 1] else 0\n'
    text += "  terms small=0 large=1\nif service is poor then tip is small\nif service is good then tip is large\n"
    for name, content in (("a.fz", text), ("shared.fz", shared)):
        (tmp_path / name).write_text(content)
    uris = {name: (tmp_path / name).as_uri() for name in ("a.fz", "shared.fz")}

    async def of(client, uri, *, wrong):
        """Wait until a document has an error, or none."""
        while True:
            found = await client.diagnostics()
            if found.uri == uri and any(d.severity == 1 for d in found.diagnostics) == wrong:
                return found.diagnostics

    async def talk(client, _):
        opened(client, text, uris["a.fz"])
        await of(client, uris["a.fz"], wrong=False)
        document = opened(client, shared, uris["shared.fz"])
        changed(client, document, 2, shared.replace("good", "great"))
        (mistake, *_rest) = await of(client, uris["a.fz"], wrong=True)
        assert mistake.code == "FZ203"
        found = await client.workspace_symbol_async(lsp.WorkspaceSymbolParams("great"))
        assert [(s.name, s.container_name, s.location.uri) for s in found] == [("great", "service", uris["shared.fz"])]
        client.text_document_did_close(lsp.DidCloseTextDocumentParams(document))
        await of(client, uris["a.fz"], wrong=False)
        (tmp_path / "shared.fz").unlink()
        change = lsp.FileEvent(uris["shared.fz"], lsp.FileChangeType.Deleted)
        client.workspace_did_change_watched_files(lsp.DidChangeWatchedFilesParams([change]))
        assert (await of(client, uris["a.fz"], wrong=True))[0].code == "FZ218"

    with_shared_server(talk)


@pytest.mark.long
def test_a_surface_is_drawn(with_shared_server):
    async def talk(client, _):
        document = opened(client, SYSTEM)
        (lens, *_rest) = await client.text_document_code_lens_async(lsp.CodeLensParams(document))
        given = lsp.ExecuteCommandParams(lens.command.command, arguments=lens.command.arguments)
        done = await client.workspace_execute_command_async(given)
        assert done["exit"] == 0
        assert "<svg" in Path(done["picture"]).read_text()

    with_shared_server(talk)
