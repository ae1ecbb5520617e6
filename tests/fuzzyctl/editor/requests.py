"""Every request that the language server answers, about a document and some places in it."""

from lsprotocol import types as lsp

AT_PLACES = {
    lsp.TEXT_DOCUMENT_COMPLETION: lsp.CompletionParams,
    lsp.TEXT_DOCUMENT_HOVER: lsp.HoverParams,
    lsp.TEXT_DOCUMENT_SIGNATURE_HELP: lsp.SignatureHelpParams,
    lsp.TEXT_DOCUMENT_DEFINITION: lsp.DefinitionParams,
    lsp.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: lsp.DocumentHighlightParams,
    lsp.TEXT_DOCUMENT_PREPARE_RENAME: lsp.PrepareRenameParams,
}
OF_TEXTS = {
    lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL: lsp.DocumentSymbolParams,
    lsp.TEXT_DOCUMENT_FOLDING_RANGE: lsp.FoldingRangeParams,
    lsp.TEXT_DOCUMENT_DOCUMENT_LINK: lsp.DocumentLinkParams,
    lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: lsp.SemanticTokensParams,
    lsp.TEXT_DOCUMENT_CODE_LENS: lsp.CodeLensParams,
    lsp.TEXT_DOCUMENT_DIAGNOSTIC: lsp.DocumentDiagnosticParams,
}
OPTIONS = lsp.FormattingOptions(2, True)


def requests(uri, places):
    """Yield each method with its parameters; ranges are from the first place to the last one."""
    document = lsp.TextDocumentIdentifier(uri)
    whole = lsp.Range(places[0], places[-1])
    for at in places:
        yield from ((method, params(document, at)) for method, params in AT_PLACES.items())
        yield lsp.TEXT_DOCUMENT_REFERENCES, lsp.ReferenceParams(lsp.ReferenceContext(True), document, at)
        yield lsp.TEXT_DOCUMENT_SELECTION_RANGE, lsp.SelectionRangeParams(document, [at])
        context = lsp.CodeActionContext([])
        yield lsp.TEXT_DOCUMENT_CODE_ACTION, lsp.CodeActionParams(document, lsp.Range(at, at), context)
        for typed in ("\n", "|"):
            params = lsp.DocumentOnTypeFormattingParams(document, at, typed, OPTIONS)
            yield lsp.TEXT_DOCUMENT_ON_TYPE_FORMATTING, params
    yield from ((method, params(document)) for method, params in OF_TEXTS.items())
    yield lsp.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, lsp.SemanticTokensRangeParams(document, whole)
    yield lsp.TEXT_DOCUMENT_INLAY_HINT, lsp.InlayHintParams(document, whole)
    yield lsp.TEXT_DOCUMENT_FORMATTING, lsp.DocumentFormattingParams(document, OPTIONS)
    yield lsp.TEXT_DOCUMENT_RANGE_FORMATTING, lsp.DocumentRangeFormattingParams(document, whole, OPTIONS)
    yield lsp.WORKSPACE_SYMBOL, lsp.WorkspaceSymbolParams("e")
