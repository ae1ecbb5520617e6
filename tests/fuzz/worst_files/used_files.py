"""Worst cases of used files."""

from worst_files.case import FILES, HEAD, cut, files_case, repeated


@files_case
def used_files(size):
    count = max(2, int(FILES * size))
    found = {
        "use.fz": "system worst\n"
        + HEAD
        + "".join(f'use "u{k}.fz"\n' for k in range(count))
        + "if x is low then y is small\n"
    }
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated(f"param p{k}_@ = @ + 1\n"), size)
    return found


@files_case
def used_files_of_inputs(size):
    count = max(2, int(FILES * size))
    found = {
        "use.fz": "system worst\n"
        + HEAD
        + "".join(f'use "u{k}.fz"\n' for k in range(count))
        + "if x is low then y is small\n"
    }
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated(f"input i{k}_@ in [0, 1]\n  terms a b c d e f g h i j k\n"), size)
    return found


@files_case
def used_files_of_mistakes(size):
    count = max(2, int(FILES * size))
    found = {
        "use.fz": "system worst\n"
        + HEAD
        + "".join(f'use "u{k}.fz"\n' for k in range(count))
        + "if x is low then y is small\n"
    }
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated("nonsense @\n"), size)
    return found


@files_case
def used_files_that_are_missing(size):
    return {"use.fz": "system worst\n" + HEAD + cut(repeated('use "gone@.fz"\n'), 0.9 * size)}


@files_case
def used_systems(size):
    count = max(2, int(FILES * size))
    uses = "".join(f'use "u{k}.fz"\n' for k in range(count))
    found = {"use.fz": "system worst\n" + HEAD + uses + "if x is low then y is small\nrequire y == nowhere.y\n"}
    for k in range(count):
        found[f"u{k}.fz"] = cut(repeated(f"system s{k}_@\n{HEAD}if x is low then y is small\n"), size)
    return found
